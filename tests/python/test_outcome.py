"""What became of a command, asked by somebody who was not told."""

from __future__ import annotations

import gecos
import pytest
from lamp import Lamp


def test_others_learn_what_became_of_a_command(lab: gecos.Lab, lamp: Lamp, held: Lamp) -> None:
    turned = held.dim(2.0)
    turned.result()
    with gecos.Lab() as other:
        outcome = gecos.outcome(other.create(Lamp, "LAMP"), turned.id).result()
    assert outcome == gecos.Outcome(gecos.Detail.DONE, "")
    assert outcome.state is gecos.State.FINISHED


def test_another_life_of_the_server_is_not_known(lamp: Lamp) -> None:
    outcome = gecos.outcome(lamp, "1-2-3").result()
    assert outcome.detail is gecos.Detail.OUTCOME_UNKNOWN
    assert "was restarted" in outcome.text


def test_what_is_no_id_is_refused(lamp: Lamp) -> None:
    with pytest.raises(ValueError, match="'7' is not the id of a command"):
        gecos.outcome(lamp, "7")

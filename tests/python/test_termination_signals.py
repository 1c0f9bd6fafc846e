from __future__ import annotations

import signal
import threading

import pytest
from gecos.termination_signals import TerminationSignals


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_that_came_before_ends_the_wait(number: signal.Signals) -> None:
    with TerminationSignals() as signals:
        signal.raise_signal(number)
        signals.wait()


def test_a_signal_given_to_another_thread_ends_the_wait() -> None:
    with TerminationSignals() as signals:
        other = threading.Thread(target=signal.raise_signal, args=(signal.SIGTERM,))
        other.start()
        signals.wait()
        other.join()


def test_afterwards_signals_do_what_they_did() -> None:
    before = signal.getsignal(signal.SIGINT)
    with TerminationSignals():
        assert signal.getsignal(signal.SIGINT) is not before
    assert signal.getsignal(signal.SIGINT) is before
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_other_signals_do_not_end_it() -> None:
    with TerminationSignals() as signals:
        before = signal.signal(signal.SIGUSR1, lambda number, frame: None)
        signal.raise_signal(signal.SIGUSR1)
        signal.raise_signal(signal.SIGTERM)
        signals.wait()
        signal.signal(signal.SIGUSR1, before)
        signals._here.setblocking(False)
        with pytest.raises(BlockingIOError):
            signals._here.recv(1)


def test_what_came_is_known_before_waiting_for_it() -> None:
    with TerminationSignals() as signals:
        before = signal.signal(signal.SIGUSR1, lambda number, frame: None)
        signal.raise_signal(signal.SIGUSR1)
        assert not signals.came()
        signal.raise_signal(signal.SIGINT)
        assert signals.came()
        signals.wait()
        signal.signal(signal.SIGUSR1, before)

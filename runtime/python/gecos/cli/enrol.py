"""The verbs `gecos lab init`, `gecos join` and `gecos approve`."""

from __future__ import annotations

import socket

import click
from click.shell_completion import CompletionItem

from gecos.cli.exit_codes import UsageFailure
from gecos.cli.options import Number, json_option, print_json

_MINUTE = 60.0
_OWNER = click.option(
    "--as",
    "owner",
    metavar="USER@HOST",
    help="The name under which your key is admitted; default: your user and this host.",
)


@click.group()
def lab() -> None:
    """Lets users of other machines join this laboratory."""


@lab.command()
@click.option("--address", metavar="HOST", help="Address for other hosts; default: the hostname.")
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="TCP port; default: any.")
@click.option("--minutes", type=Number(0.001), default=10.0, help="Minutes until the link expires.")
@_OWNER
@json_option
def init(address: str | None, port: int, minutes: float, owner: str | None, as_json: bool) -> None:
    """Prints a link that invites a user to this laboratory, and waits until that user joins.

    Send the link over a channel that no stranger can read. The link works once. When the user has
    joined, compare the fingerprints and run `gecos approve`.
    """
    from gecos import enrolment, key_folder

    where = address or socket.gethostname()
    with enrolment.Invitation(where, port, lives=minutes * _MINUTE) as invitation:
        if as_json:
            print_json({"link": str(invitation.url)})
        else:
            print(f"gecos join {invitation.url}", flush=True)
        try:
            party = invitation.wait(owner or _this_owner())
        except enrolment.EnrolmentError as error:
            raise TimeoutError(str(error)) from None
    if as_json:
        print_json({"key": party.key, "owner": party.owner})
    else:
        print(f"{party.owner} asks to join, with the key {key_folder.fingerprint(party.key)}")
        print("compare this fingerprint with the one that `gecos join` printed;")
        print(f"if both fingerprints are equal, run: gecos approve {party.owner}")


@click.command()
@click.argument("url", metavar="LINK")
@_OWNER
@click.option("--yes", is_flag=True, help="Admit the laboratory's key without asking.")
@json_option
def join(url: str, owner: str | None, yes: bool, as_json: bool) -> None:
    """Asks to join the laboratory that has printed LINK.

    Then shows the name and the key of the laboratory's user, and admits this key if you confirm
    that you expect this user. The lists in your lab file determine what the user may do on this
    host.
    """
    from gecos import enrolment, key_folder

    who = owner or _this_owner()
    try:
        laboratory = enrolment.join(enrolment.JoinUrl.parse(url), who)
        digits = key_folder.fingerprint(laboratory.key)
        question = f"Admit the laboratory of {laboratory.owner}, with the key {digits}?"
        if not yes and not click.confirm(question, err=True):
            raise UsageFailure(
                "you did not admit the laboratory's key, so you cannot reach the laboratory"
            )
        enrolment.admit(laboratory)
    except enrolment.EnrolmentError as error:
        raise UsageFailure(str(error)) from None
    own = key_folder.own_key()
    if as_json:
        print_json({"key": own, "owner": who, "laboratory": laboratory.owner})
    else:
        print(f"{laboratory.owner} was asked to admit {who}, with the key")
        print(key_folder.fingerprint(own))


def _waiting(_: click.Context, __: click.Parameter, begun: str) -> list[CompletionItem]:
    from gecos import enrolment

    try:
        found = enrolment.requests()
    except (OSError, RuntimeError, enrolment.EnrolmentError):
        return []
    return [CompletionItem(one.owner) for one in found if one.owner.startswith(begun)]


@click.command()
@click.argument("name", shell_complete=_waiting)
@json_option
def approve(name: str, as_json: bool) -> None:
    """Admits the key of a user who has joined. NAME is USER@HOST, or at least 8 digits of the
    fingerprint."""
    from gecos import enrolment, key_folder

    try:
        party = enrolment.approve(name)
    except enrolment.EnrolmentError as error:
        raise UsageFailure(str(error)) from None
    if as_json:
        print_json({"key": party.key, "owner": party.owner})
    else:
        print(f"admitted  {key_folder.fingerprint(party.key)}  {party.owner}")
        print(f"if the other machine shows another fingerprint: gecos revoke {party.owner}")


def _this_owner() -> str:
    from gecos.key_folder import this_user

    return f"{this_user()}@{socket.gethostname()}"

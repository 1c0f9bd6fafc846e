"""The verb `gecos revoke`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gecos.cli.exit_codes import ExitCode, UsageFailure
from gecos.cli.options import broker_option, json_option, print_json

_APPLIED_WITHIN = 3.0
"""Longest wait in s until the servers that hear the broker have applied a revocation. Each server
asks the broker once a second."""
_BETWEEN_LOOKS = 0.1  # s

if TYPE_CHECKING:
    from gecos import Lab
    from gecos.cli.presence import Presence
    from gecos.key_folder import Admitted


@click.command()
@click.argument("name")
@broker_option
@json_option
def revoke(name: str, broker: str | None, as_json: bool) -> int:
    """Removes the keys of a user, and ends that user's sessions.

    NAME is an owner of keys, as anna@desk, or as anna for all hosts, or at least 8 digits of a
    fingerprint. Your servers on this host end the sessions and streams within 5 s, and so do all
    servers that hear the broker, if the broker runs as you. Servers that were not reached, and
    lists that still name the user, are printed; the exit code is then 3. A server that the broker
    does not reach applies the revocation at its next contact with the broker.
    """
    gone = _remove(name)
    reached, missed = _servers(broker, name, gone)
    missed += _still_named(name, gone)
    if as_json:
        keys = [{"key": one.key, "owner": one.owner} for one in gone]
        print_json({"removed": keys, "reached": reached, "missed": missed})
    else:
        for one in gone:
            print(f"removed   {one.file}" + (f" of {one.owner}" if one.owner else ""))
        if reached:
            print(f"reached   {', '.join(reached)}: its sessions end within 5 s")
        for why in missed:
            print(f"gecos: {why}", file=sys.stderr)
    return ExitCode.COMMAND_FAILED if missed else ExitCode.FINISHED


def _remove(name: str) -> list[Admitted]:
    from gecos import key_folder

    try:
        return key_folder.revoke(name)
    except key_folder.KeyFolderError as error:
        if _rule_that_admits(name):
            return []
        raise UsageFailure(str(error)) from None


def _servers(broker: str | None, name: str, gone: list[Admitted]) -> tuple[list[str], list[str]]:
    """Returns the objects whose servers apply the revocation, and the reasons why other servers do
    not."""
    import gecos
    from gecos.cli.presence import presences

    try:
        with gecos.Lab(broker) as lab:
            found = presences(lab)
            behind = _behind(lab, name, gone)
    except ConnectionError as error:
        return [], [
            f"the broker lists no servers, so servers of other users were not reached: {error}"
        ]
    reached, missed = [], []
    for one in found:
        why = _why_missed(one, name)
        if why is not None and behind is not None:
            why = _why_behind(one, behind)
        if why is None:
            reached.append(one.entry.name)
        else:
            missed.append(f"{one.entry.name} was not reached: {why}")
    return reached, missed


def _behind(lab: Lab, name: str, gone: list[Admitted]) -> list[str] | None:
    """Waits for a limited time until all servers that the broker hears have applied the revocation.
    Returns the objects whose servers have not applied it. Returns None if the broker does not tell
    the revocation to the servers, because the broker runs as another user or is of an older
    version."""
    import time

    from gecos_idl.broker import Broker
    from gecos_idl.broker_types import Revocation

    from gecos.errors import CommandFailed, ConnectionFailed
    from gecos.key_folder import revocations_of

    wanted = [Revocation(key=one.key, owner=one.owner) for one in revocations_of(name, gone)]
    if not wanted:
        return None
    end = time.monotonic() + _APPLIED_WITHIN
    try:
        while True:
            state = lab.broker(Broker, patience=_APPLIED_WITHIN).behind(wanted).result()
            if not state.listed:
                return None
            if not state.behind or time.monotonic() >= end:
                return list(state.behind)
            time.sleep(_BETWEEN_LOOKS)
    except (CommandFailed, ConnectionFailed):
        return None


def _why_behind(one: Presence, behind: list[str]) -> str | None:
    """Returns why a server does not know of the revocation yet, or None if it does."""
    runs_as = f"its server runs as {one.entry.user}@{one.entry.hostname}, and "
    if one.silent_since is not None:
        return (
            f"{runs_as}the broker does not hear that server; the server applies the revocation "
            "when it reaches the broker again"
        )
    if one.entry.name in behind:
        return f"{runs_as}has not applied the revocation within {_APPLIED_WITHIN:g} s"
    return None


def _why_missed(one: Presence, name: str) -> str | None:
    """Returns why a server does not read the key folder of this user now, or None if it does."""
    from gecos import _core
    from gecos.key_folder import this_user

    boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    entry = one.entry
    here = entry.host.startswith(boot) and any(
        address.startswith(f"shm:{_core.runtime_directory()}/") for address in entry.addresses
    )
    if not here or entry.user != this_user():
        return f"its server runs as {entry.user}@{entry.hostname}; run `gecos revoke {name}` there"
    if not one.answers:
        return f"its server does not answer, and will end the sessions later ({one.problem})"
    return None


def _still_named(name: str, gone: list[Admitted]) -> list[str]:
    """Returns the rules of the lab file by which the user is still admitted over shared memory,
    each as a text with advice. Only users of this host connect over shared memory."""
    names = {name, *(one.owner for one in gone if one.owner is not None)}
    rules = {rule for one in sorted(names) if (rule := _rule_that_admits(one))}
    return [f"{rule}; remove the name there, too" for rule in sorted(rules)]


def _rule_that_admits(name: str) -> str | None:
    """Returns the rule of the lab file that admits a user, `name`. Returns None if no rule does,
    and always for users of other hosts, for this user and for root."""
    import socket

    from gecos import _core
    from gecos.cli.policy import named_file, text_of
    from gecos.key_folder import this_user

    user, _, host = name.partition("@")
    here = socket.gethostname()
    path = named_file()
    if path is None or (host and host != here) or user == this_user():
        return None
    server = (this_user(), here)
    try:
        allowed, rule = _core.may_connect(text_of(path), str(path), server, (user, here), "BROKER")
    except ValueError as error:
        raise UsageFailure(str(error)) from None
    return rule if allowed and user != "root" else None

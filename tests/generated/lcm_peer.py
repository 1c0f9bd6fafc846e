"""Run as a program with lcm-gen's Python on its path: reads pairs of type and message (in hex) from
stdin, writes what lcm-gen's code makes of each: its fingerprint, the message again, its members.
"""

import json
import sys
from importlib import import_module


def shown(value):
    """What JSON can hold of a decoded member."""
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, bytes):
        return list(value)
    if isinstance(value, list | tuple):
        return [shown(item) for item in value]
    return {name: shown(getattr(value, name)) for name in value.__slots__}


def main():
    answers = []
    for name, message in json.load(sys.stdin):
        package, _, simple = name.rpartition(".")
        kind = getattr(import_module(package), simple)
        value = kind.decode(bytes.fromhex(message))
        answers.append(
            {
                "fingerprint": kind._get_packed_fingerprint().hex(),
                "message": value.encode().hex(),
                "members": shown(value),
            }
        )
    json.dump(answers, sys.stdout)


main()

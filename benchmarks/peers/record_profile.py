"""Calls as they are made in life, by programs that were built to record which branches they take:
alone and many at a time, across cores and on one, at once and after silence, over shm and lcm; the
samples of a stream; and images, polled and waited for.
tools/build_release.sh builds by what they record."""

from __future__ import annotations

import argparse
import contextlib
import os
from pathlib import Path

from bench_peers import own_laboratory
from candidates import candidates
from pair import Candidate, Pair

CALLS = ("trips 0.5", "unchecked 0.5", "outstanding 64 0.5", "silent 0.02 25")
STREAM = ("look 0.2", "publish 0.2")
IMAGES = ("images 0.5",)


def record(
    candidate: Candidate, questions: tuple[str, ...], cores: list[int], env: dict[str, str]
) -> None:
    with contextlib.closing(Pair(candidate, cores[-1], env)) as pair:
        client = pair.client(cores[:1])
        for question in questions:
            client.say(question)
            print(f"{candidate.name}, cores {cores}, {question}: {client.line()}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=Path, required=True, help="built with GECOS_PROFILE=record")
    build = parser.parse_args().build.resolve()
    ours = candidates(build)
    cores = sorted(os.sched_getaffinity(0))[:2]
    with own_laboratory(build) as env:
        for among in (cores, cores[:1]):
            for candidate in (ours.ours, ours.ours_lcm):
                record(candidate, CALLS, among, env)
        record(ours.ours, STREAM, cores, env)
        for candidate in (ours.images.ours, ours.images.ours_polled):
            record(candidate, IMAGES, cores, env)


if __name__ == "__main__":
    main()

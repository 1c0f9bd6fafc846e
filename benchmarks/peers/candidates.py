"""Whom `make bench-peers` measures, and how each is started."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from pair import Candidate

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True, slots=True)
class ImageCandidates:
    """Those that send and read images."""

    copy: Candidate
    ours_polled: Candidate
    ours: Candidate
    ours_python: Candidate
    omniorb: Candidate
    ice: Candidate
    capnp: Candidate
    iceoryx_polled: Candidate
    iceoryx: Candidate
    iceoryx2_polled: Candidate
    iceoryx2: Candidate
    iceoryx2_python: Candidate


@dataclass(frozen=True, slots=True)
class Candidates:
    """All candidates, by the names in the tables."""

    spin: Candidate
    yielding: Candidate
    futex: Candidate
    socket: Candidate
    raw_lcm: Candidate
    ours: Candidate
    ours_lcm: Candidate
    ours_python: Candidate
    omniorb: Candidate
    ice: Candidate
    capnp: Candidate
    iceoryx_polled: Candidate
    iceoryx: Candidate
    iceoryx2_polled: Candidate
    iceoryx2: Candidate
    iceoryx2_python: Candidate
    iceoryx_topics: Candidate
    iceoryx2_topics: Candidate
    images: ImageCandidates

    def blocking(self) -> tuple[Candidate, ...]:
        return (self.omniorb, self.ice, self.capnp, self.iceoryx, self.iceoryx2)

    def polled(self) -> tuple[Candidate, ...]:
        return (self.iceoryx_polled, self.iceoryx2_polled)

    def peers(self) -> tuple[Candidate, ...]:
        return (*self.polled(), *self.blocking(), self.iceoryx2_python)


def candidates(build: Path) -> Candidates:
    ours = build / "benchmarks" / "peers"
    theirs = build / "peers"
    iceoryx2 = theirs / "cargo" / "release" / "iceoryx2_peer"

    def of(name: str, peer: str, program: Path, how: str, *client: str | Path) -> Candidate:
        return Candidate(
            name, peer, (program, "serve", how), (*(client or (program,)), "call", how)
        )

    gecos_client = (sys.executable, HERE / "gecos_client.py")
    iceoryx2_client = (theirs / "venv" / "bin" / "python", HERE / "iceoryx2_client.py")
    images = ImageCandidates(
        copy=of("raw copy", "", ours / "limits_peer", "images-copy"),
        ours_polled=of("**ours**, polled", "", ours / "gecos_peer", "images-poll"),
        ours=of("**ours**", "", ours / "gecos_peer", "images-wait"),
        ours_python=of(
            "**ours**, polled from Python", "", ours / "gecos_peer", "images-poll", *gecos_client
        ),
        omniorb=of("omniORB", "omniorb", theirs / "omniorb_peer", "images"),
        ice=of("Ice", "ice", theirs / "ice_peer", "images"),
        capnp=of("Cap'n Proto", "capnp", theirs / "capnp_peer", "images"),
        iceoryx_polled=of("iceoryx, polled", "iceoryx", theirs / "iceoryx_peer", "images-poll"),
        iceoryx=of("iceoryx, WaitSet", "iceoryx", theirs / "iceoryx_peer", "images-wait"),
        iceoryx2_polled=of("iceoryx2, polled", "iceoryx2", iceoryx2, "images-poll"),
        iceoryx2=of("iceoryx2, events", "iceoryx2", iceoryx2, "images-wait"),
        iceoryx2_python=of(
            "iceoryx2, polled from Python", "iceoryx2-python", iceoryx2, "images-poll",
            *iceoryx2_client,
        ),
    )  # fmt: skip
    return Candidates(
        spin=of("raw ring, spinning", "", ours / "limits_peer", "spin"),
        yielding=of("raw ring, yields, then futex", "", ours / "limits_peer", "yield"),
        futex=of("raw ring, futex", "", ours / "limits_peer", "futex"),
        socket=of("raw Unix socket", "", ours / "limits_peer", "socket"),
        raw_lcm=of("raw LCM", "", ours / "limits_peer", "lcm"),
        ours=of("**ours**", "", ours / "gecos_peer", "shm"),
        ours_lcm=of("**ours**, encrypted", "", ours / "gecos_peer", "lcm"),
        ours_python=of("**ours**, from Python", "", ours / "gecos_peer", "shm", *gecos_client),
        omniorb=of("omniORB", "omniorb", theirs / "omniorb_peer", "unix"),
        ice=of("Ice", "ice", theirs / "ice_peer", "tcp"),
        capnp=of("Cap'n Proto", "capnp", theirs / "capnp_peer", "unix"),
        iceoryx_polled=of("iceoryx, polled", "iceoryx", theirs / "iceoryx_peer", "poll"),
        iceoryx=of("iceoryx, WaitSet", "iceoryx", theirs / "iceoryx_peer", "wait"),
        iceoryx2_polled=of("iceoryx2, polled", "iceoryx2", iceoryx2, "poll"),
        iceoryx2=of("iceoryx2, events", "iceoryx2", iceoryx2, "wait"),
        iceoryx2_python=of(
            "iceoryx2, polled from Python", "iceoryx2-python", iceoryx2, "poll", *iceoryx2_client
        ),
        iceoryx_topics=of(
            "iceoryx, publish/subscribe", "iceoryx", theirs / "iceoryx_peer", "topics"
        ),
        iceoryx2_topics=of("iceoryx2, publish/subscribe", "iceoryx2", iceoryx2, "topics"),
        images=images,
    )

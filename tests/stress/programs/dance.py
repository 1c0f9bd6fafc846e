"""Holds DANCER under a password, and makes it do what its input says."""

from __future__ import annotations

import sys

import gecos
from feeder import Dancer, Remark, Step


def move(dancer: Dancer) -> None:
    follow = dancer.follow()
    while follow.feedback() is None:
        follow.wait(0.002)
    alter = dancer.alter.writer()
    alter.feeds(follow)
    for count in range(1, 5):
        alter.send(Step(x=0.025, count=count))
        while follow.feedback().count != count:
            follow.wait(0.002)
    alter.send(Step(x=0.0, count=-1))
    print(f"moved {follow.result():.3f}", flush=True)


def main(password: str) -> None:
    with gecos.Lab() as lab:
        dancer = lab.create(Dancer, "DANCER", medium="lcm")
        lease = gecos.actor(dancer, password)
        speed, remark = dancer.speed.writer(), dancer.remark.writer()
        print("holds", flush=True)
        for line in sys.stdin:
            match line.split():
                case ["move"]:
                    move(dancer)
                case ["speed", value]:
                    speed.send(float(value))
                    print("sent", flush=True)
                case ["remark", text]:
                    remark.send(Remark(text=text))
                    print("sent", flush=True)
                case ["feet"]:
                    print("feet", dancer.feet().result(), flush=True)
                case ["stop"]:
                    gecos.stop(dancer).result()
                    print("stopped", flush=True)
        lease.release()


if __name__ == "__main__":
    main(sys.argv[1])

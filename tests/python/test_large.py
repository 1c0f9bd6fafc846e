"""Values as large as images, over each medium and between processes."""

from __future__ import annotations

import random
from collections.abc import Iterator

import gecos
import pytest
from camera import Camera, InvertingCamera, inverted
from test_process import running, says

IMAGE = 2_000_000


def film(seed: int, size: int = IMAGE) -> bytes:
    return random.Random(seed).randbytes(size)


@pytest.fixture
def camera_server(lab: gecos.Lab) -> Iterator[gecos.Server]:
    with gecos.Server(lab) as server:
        server.add("CAMERA", InvertingCamera(), simulated=True)
        yield server


@pytest.mark.parametrize("medium", ["inproc", "shm", "lcm"])
def test_an_image_goes_both_ways(lab: gecos.Lab, camera_server: gecos.Server, medium: str) -> None:
    camera = lab.create(Camera, "CAMERA", medium=medium)
    for seed in range(3):
        sent = film(seed)
        assert camera.develop(sent).result() == inverted(sent)


SERVING = """
import gecos
from camera import InvertingCamera
gecos.serve({"CAMERA": InvertingCamera()}, simulated=True)
"""


def test_many_images_at_once_from_another_process(lab: gecos.Lab) -> None:
    with running(SERVING) as server:
        assert says(server) == "serving CAMERA\n"
        camera = lab.create(Camera, "CAMERA", medium="shm")
        films = [film(seed, IMAGE + seed) for seed in range(7)]
        commands = [camera.develop(sent) for sent in films]
        for sent, command in zip(films, commands, strict=True):
            assert command.result() == inverted(sent)


def test_when_the_server_is_killed_among_images_every_command_ends(lab: gecos.Lab) -> None:
    with running(SERVING) as server:
        assert says(server) == "serving CAMERA\n"
        camera = lab.create(Camera, "CAMERA", medium="shm")
        films = [film(seed) for seed in range(7)]
        commands = [camera.develop(sent) for sent in films]
        assert commands[0].result() == inverted(films[0])
        server.kill()
        for sent, command in zip(films, commands, strict=True):
            if command.wait() is gecos.State.FINISHED:
                assert command.result() == inverted(sent)
            else:
                assert command.progress().detail in (
                    gecos.Detail.SERVER_CRASHED,
                    gecos.Detail.NOT_STARTED,
                )


def test_what_is_too_large_is_refused_with_its_size(
    lab: gecos.Lab, camera_server: gecos.Server
) -> None:
    camera = lab.create(Camera, "CAMERA", medium="shm")
    command = camera.develop(bytes(32 * 1024 * 1024))
    assert command.wait() is gecos.State.COMMAND_FAILED
    assert "take 33554436 bytes, but shm carries at most 33554432" in str(command.exception())

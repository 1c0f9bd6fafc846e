"""Images in Python: octets that are written and read in the memory of the medium, without a
copy."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gecos
import numpy as np
import pytest
from gecos.wire import DecodeError, EncodeError
from generated_module import imported

TREE = Path(__file__).resolve().parents[2]
FULL = 1920 * 1080 * 3


@pytest.fixture(scope="module")
def images(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The generated module of camera.gidl."""
    out = tmp_path_factory.mktemp("images")
    root = TREE / "tests" / "idl"
    with imported("images.camera", root / "images" / "camera.gidl", root, out) as module:
        yield module


@pytest.fixture
def servant(images: Any) -> Any:
    class PlainCamera(images.CameraServant):  # type: ignore[misc]
        def picture(self) -> Any:
            return images.Image()

        def scan(self) -> Any:
            return images.Sweep()

        def still(self) -> Any:
            return images.Frame()

        def raw(self) -> Any:
            return images.Dump()

        def both(self) -> Any:
            return images.Stereo()

    return PlainCamera()


@pytest.fixture(params=["inproc", "shm"])
def medium(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def served(lab: gecos.Lab, servant: Any) -> Iterator[gecos.Server]:
    with gecos.Server(lab) as server:
        server.add("CAMERA", servant, simulated=True)
        yield server


@pytest.fixture
def camera(lab: gecos.Lab, served: gecos.Server, images: Any, medium: str) -> Any:
    return lab.create(images.Camera, "CAMERA", medium=medium)


def publish(servant: Any, images: Any, first: int, octets: int = 12) -> Any:
    """Publishes a picture, and returns the array through which it was written."""
    with servant.lend_picture(images.Image(width=first, encoding="mono8"), octets) as loan:
        array = np.asarray(loan.octets)
        array[:] = np.arange(first, first + octets)
        assert loan.publish()
    return array


def address(array: Any) -> int:
    return int(array.__array_interface__["data"][0])


def mapping_of(array: Any) -> tuple[str, int]:
    """Returns the line of /proc/self/maps with the memory of `array`, and the offset in it."""
    for line in Path("/proc/self/maps").read_text().splitlines():
        begin, end = (int(word, 16) for word in line.split()[0].split("-"))
        if begin <= address(array) < end:
            return line, address(array) - begin
    raise AssertionError("the memory is not mapped")


def test_a_picture_is_an_array_over_the_memory_where_it_was_written(
    camera: Any, servant: Any, images: Any, medium: str
) -> None:
    with camera.picture.stream() as stream:
        written = publish(servant, images, 5)
        sample = stream.next_in_place(10)
        read = np.asarray(sample.octets)
        assert sample.value == images.Image(width=5, encoding="mono8")
        assert read.dtype == np.uint8
        assert read.tolist() == list(range(5, 17))
        assert not read.flags.writeable
        written[7] = 99  # which a servant may not do: the reader sees it, so nothing was copied
        assert read[7] == 99
        if medium == "inproc":
            assert address(read) == address(written)
        else:
            readers, place = mapping_of(read)
            writers, same_place = mapping_of(written)
            assert "memfd:gecos stream" in readers
            assert "r--s" in readers
            assert "rw-s" in writers
            assert place == same_place
        assert sample.intact()


def test_a_full_screen_is_filled_in_place(camera: Any, servant: Any, images: Any) -> None:
    with camera.still.stream() as stream:
        for number in range(1, 21):
            with servant.lend_still(images.Frame(number=number), FULL) as loan:
                np.asarray(loan.octets).reshape(1080, 1920, 3)[...] = number
                loan.publish(stamp=1.5)
            sample = stream.next_in_place(10)
            picture = np.asarray(sample.octets).reshape(1080, 1920, 3)
            assert (sample.value.number, sample.stamp) == (number, 1.5)
            assert (picture == number).all()
            assert sample.intact()


def test_copies_and_samples_in_place_are_read_in_turn(
    camera: Any, servant: Any, images: Any
) -> None:
    with camera.picture.stream() as stream:
        assert stream.latest_in_place() is None
        publish(servant, images, 1)
        assert bytes(stream.next_in_place(10).octets)[0] == 1
        assert stream.latest().value.pixels[0] == 1
        assert stream.latest_in_place().octets[0] == 1
        publish(servant, images, 2)
        assert stream.next(10).value.pixels == bytes(range(2, 14))
        servant.publish_picture(images.Image(pixels=b"whole", mask=b"m"))
        sample = stream.next_in_place(10)
        assert bytes(sample.octets) == b"whole"
        assert sample.value == images.Image(mask=b"m")
        assert (sample.sequence, sample.lost) == (3, 0)
        assert stream.counts.received == 3
        with pytest.raises(TimeoutError):
            stream.next_in_place(0)


def test_a_held_picture_is_overwritten_after_the_depth_and_stays_readable(
    lab: gecos.Lab, camera: Any, servant: Any, images: Any, served: gecos.Server
) -> None:
    stream = camera.picture.stream()
    publish(servant, images, 1)
    held = stream.next_in_place(10)
    for first in range(2, 5):
        publish(servant, images, first)
    assert held.intact()
    publish(servant, images, 5)
    assert not held.intact()
    after = stream.next_in_place(10)
    assert (after.lost, after.octets[0]) == (1, 3)
    array = np.asarray(after.octets)
    stream.close()
    served.close()
    lab.close()
    del stream, after
    assert array.tolist() == list(range(3, 15))


def test_a_loan_that_is_not_published_is_no_sample(camera: Any, servant: Any, images: Any) -> None:
    with camera.picture.stream() as stream:
        with servant.lend_picture(images.Image(), 4) as loan:
            with pytest.raises(ValueError, match="in s of Unix time"):
                loan.publish(stamp=1.7e12)
            with pytest.raises(ValueError, match="the memory of the next sample is lent"):
                servant.lend_picture(images.Image(), 4)
            loan.octets[0] = 1
        assert not loan.publish()
        with pytest.raises(ValueError, match="released"):
            loan.octets[0] = 1
        publish(servant, images, 7)
        sample = stream.next_in_place(10)
        assert (sample.sequence, sample.octets[0]) == (1, 7)


def test_what_cannot_be_lent_is_refused(
    camera: Any, servant: Any, images: Any, served: gecos.Server
) -> None:
    with pytest.raises(EncodeError, match=r"Image.pixels.*50001.*50000"):
        servant.lend_picture(images.Image(), 50_001)
    with pytest.raises(EncodeError, match="leave it empty, and write them into the loan"):
        servant.lend_picture(images.Image(pixels=b"x"), 4)
    with pytest.raises(EncodeError, match=r"Image\.encoding"):
        servant.lend_picture(images.Image(encoding="x" * 17), 4)
    with pytest.raises(ValueError, match="-1 octets; give 0 or more"):
        servant.lend_picture(images.Image(), -1)
    with pytest.raises(ValueError, match="at most 65536 fit; declare bounds for its sequences"):
        servant.lend_raw(images.Dump(), 100_000)
    core = servant._gecos_core
    served.close()
    with pytest.raises(gecos.ServeError, match="while it is not served"):
        servant.lend_picture(images.Image(), 4)
    servant._gecos_core = core  # as if the server were just closing
    with pytest.raises(gecos.ServeError, match="while it is not served"):
        servant.lend_picture(images.Image(), 4)


def test_a_stream_without_one_bulk_sequence_is_not_read_in_place(camera: Any, servant: Any) -> None:
    assert not hasattr(servant, "lend_both")
    with camera.both.stream() as stream, pytest.raises(TypeError, match="several @bulk members"):
        stream.next_in_place(0)


def test_a_sample_that_a_cancelled_task_returned_is_read_in_place(
    camera: Any, servant: Any, images: Any
) -> None:
    stream = camera.picture.stream()

    async def give_up() -> None:
        async for _ in stream:
            raise AssertionError("nothing is published yet")

    async def main() -> None:
        task = asyncio.create_task(give_up())
        await asyncio.sleep(0)  # lets the task begin
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    asyncio.run(main())
    publish(servant, images, 4)
    assert stream.next_in_place(10).octets[0] == 4
    stream.close()


def test_damaged_samples_are_refused_as_by_the_other_decoder(images: Any) -> None:
    codec = images._CAMERA_PICTURE.in_place
    head, tail = codec.encode(images.Image(width=3, encoding="mono8", mask=b"\1\2"), 6)
    good = head + b"pixels" + tail
    assert images._CAMERA_PICTURE.result(gecos.wire.Decoder(good)).pixels == b"pixels"
    value, octets = codec.decode(memoryview(good))
    assert bytes(octets) == b"pixels"
    assert value.mask == b"\1\2"
    for at in range(len(good)):
        for damaged in (good[:at], good[:at] + b"\xff" + good[at + 1 :]):
            try:
                whole = images._CAMERA_PICTURE.result(gecos.wire.Decoder(damaged))
            except DecodeError as error:
                with pytest.raises(DecodeError) as raised:
                    codec.decode(memoryview(damaged))
                assert str(raised.value) == str(error)
            else:
                value, octets = codec.decode(memoryview(damaged))
                value.pixels = bytes(octets)
                assert value == whole

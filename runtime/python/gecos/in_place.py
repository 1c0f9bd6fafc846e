"""Samples of which the @bulk octets, such as the pixels of an image, are written and read in the
memory that publisher and readers share."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field
from types import TracebackType
from typing import TYPE_CHECKING, Generic, Self, TypeVar

from gecos.stamp import in_ns

if TYPE_CHECKING:
    from gecos import _core

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class SampleInPlace(Generic[T]):
    """One value of a stream that is read where its publisher wrote it. `octets` is a read-only view
    of the @bulk sequence, which is empty in `value`; `numpy.asarray(sample.octets)` is an array
    without a copy. Over a medium without shared memory, the octets are in a private copy.

    The memory stays readable as long as a view or an array of it exists. A publisher never waits
    for its readers. It overwrites the octets after it has published as many further samples as the
    `depth` of the stream. Call `intact()` after you have used the octets, and discard the results
    if `intact()` returns False."""

    value: T
    octets: memoryview
    sequence: int  # this and the following members are as in Sample
    lost: int
    stamp: float
    age: float
    _memory: _core.LentSample | None = field(repr=False, compare=False)

    def intact(self) -> bool:
        """Returns whether the publisher has not yet begun to overwrite the octets."""
        return self._memory is None or self._memory.intact()


class Loan:
    """The next sample of a stream, in the memory where its readers find it. Fill `octets`, for
    example with `numpy.asarray(loan.octets)[:] = …`, and call `publish`. If `publish` is not
    called, the loan ends with its `with` block, and no sample is published. While a stream has a
    loan, nothing else can be published on this stream."""

    def __init__(self, core: _core.Loan) -> None:
        self._core = core
        # Not initialized. Must not be used after the end of the loan.
        self.octets = memoryview(core)

    def publish(self, stamp: float | None = None) -> bool:
        """Publishes the sample and ends the loan. Returns False if the servant is no longer served,
        or if the loan has ended. `stamp`: Unix time in s; None: now."""
        return self._core.publish(in_ns(stamp))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._core.give_back()
        with contextlib.suppress(BufferError):  # an array of the octets still exists
            self.octets.release()

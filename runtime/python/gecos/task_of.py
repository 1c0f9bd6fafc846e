"""Makes an awaitable acceptable to `asyncio.TaskGroup.create_task`, which accepts only
coroutines."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Coroutine
from typing import TYPE_CHECKING, Any, TypeVar
from weakref import WeakKeyDictionary

if TYPE_CHECKING:
    import asyncio

T = TypeVar("T", covariant=True)

_steps: WeakKeyDictionary[asyncio.Task[Any], Coroutine[Any, Any, Any]] = WeakKeyDictionary()
"""The coroutine of each task that runs a `TaskOf`. Several tasks may run the same `TaskOf`."""


class TaskOf(Coroutine[Any, Any, T]):
    """A base class of awaitables. Only `asyncio` calls the methods `send` and `throw`; a program
    writes `await`."""

    __slots__ = ()

    @abstractmethod
    async def _awaited(self) -> T: ...

    def send(self, value: Any) -> Any:
        return self._of_this_task().send(value)

    def throw(self, *error: Any) -> Any:
        return self._of_this_task().throw(*error)

    def close(self) -> None:
        """Does nothing, so that the awaited command continues."""

    def _of_this_task(self) -> Coroutine[Any, Any, T]:
        import asyncio

        task = asyncio.current_task()
        if task is None:
            raise RuntimeError("only asyncio may call `send` and `throw`; use `await` instead")
        if task not in _steps:
            _steps[task] = self._awaited()
        return _steps[task]

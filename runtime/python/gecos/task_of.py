"""What lets `asyncio.TaskGroup.create_task` take an awaitable: it takes coroutines only."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Coroutine
from typing import TYPE_CHECKING, Any, TypeVar
from weakref import WeakKeyDictionary

if TYPE_CHECKING:
    import asyncio

T = TypeVar("T", covariant=True)

_steps: WeakKeyDictionary[asyncio.Task[Any], Coroutine[Any, Any, Any]] = WeakKeyDictionary()
"""The coroutine that each task of a `TaskOf` runs. Several tasks may wait for the same object."""


class TaskOf(Coroutine[Any, Any, T]):
    """A base class of awaitables. `asyncio` calls `send` and `throw`, programs do not."""

    __slots__ = ()

    @abstractmethod
    async def _awaited(self) -> T: ...

    def send(self, value: Any) -> Any:
        return self._of_this_task().send(value)

    def throw(self, *error: Any) -> Any:
        return self._of_this_task().throw(*error)

    def close(self) -> None:
        """Does nothing: what is awaited goes on."""

    def _of_this_task(self) -> Coroutine[Any, Any, T]:
        import asyncio

        task = asyncio.current_task()
        if task is None:
            raise RuntimeError("only a task of asyncio calls this; write `await`")
        if task not in _steps:
            _steps[task] = self._awaited()
        return _steps[task]

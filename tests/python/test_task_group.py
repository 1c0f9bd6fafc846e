from __future__ import annotations

import asyncio

from lamp import Lamp


def test_a_task_group_takes_commands_and_two_tasks_may_wait_for_one(held: Lamp) -> None:
    async def both() -> list[object]:
        label = held.label()
        async with asyncio.TaskGroup() as group:
            tasks = [group.create_task(each) for each in (label, label, held.shine(1.0))]
        return [task.result() for task in tasks]

    assert asyncio.run(both()) == ["a lamp", "a lamp", None]

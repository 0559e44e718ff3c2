"""Tasks that live as long as a block of code, in a task group."""

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from typing import Any, TypeAlias

Spawn: TypeAlias = Callable[[Coroutine[Any, Any, None]], asyncio.Task[None]]


@asynccontextmanager
async def background_tasks() -> AsyncIterator[Spawn]:
    """Give the block a function that starts tasks, and end them all when the block ends.

    A task that fails ends the block and the other tasks. What failed first is raised as it is, not in an
    exception group.
    """
    failure: BaseException | None = None
    try:
        async with asyncio.TaskGroup() as group:
            tasks: set[asyncio.Task[None]] = set()

            def spawn(work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
                task = group.create_task(work)
                tasks.add(task)
                task.add_done_callback(tasks.discard)
                return task

            yield spawn
            for task in tasks:
                task.cancel()
    except BaseExceptionGroup as failures:
        failure = _first(failures)
    if failure is not None:  # raised out here, it keeps its own cause and context
        raise failure


def _first(failure: BaseException) -> BaseException:
    while isinstance(failure, BaseExceptionGroup):
        failure = failure.exceptions[0]
    return failure

"""Virtual time jumps over waits, in order, and is the same each time."""

import asyncio

import pytest

from companion import clock


async def _ticks() -> list[tuple[str, float]]:
    seen: list[tuple[str, float]] = []

    async def tick(name: str, period_s: float, count: int) -> None:
        for _ in range(count):
            await asyncio.sleep(period_s)
            seen.append((name, clock.now()))

    async with asyncio.TaskGroup() as tasks:
        tasks.create_task(tick("fast", 0.25, 8))
        tasks.create_task(tick("slow", 1000.0, 2))
    return seen


def test_virtual_time_jumps_over_waits_in_order() -> None:
    seen = clock.run(_ticks(), virtual=True)
    assert [time_s for _, time_s in seen] == [0.25 * k for k in range(1, 9)] + [1000.0, 2000.0]
    assert seen == clock.run(_ticks(), virtual=True)


def test_a_timeout_ends_a_wait_in_virtual_time() -> None:
    async def wait_for_nothing() -> float:
        try:
            async with asyncio.timeout(3600.0):
                await asyncio.Event().wait()
        except TimeoutError:
            return clock.now()
        return -1.0

    assert clock.run(wait_for_nothing(), virtual=True) == 3600.0


def test_real_time_is_the_loop_s_own() -> None:
    async def read() -> tuple[float, float]:
        return clock.now(), asyncio.get_running_loop().time()

    first, second = clock.run(read())
    assert first <= second


def test_virtual_time_stands_still_for_work_in_a_thread() -> None:
    async def work() -> tuple[float, int]:
        ticking = asyncio.create_task(asyncio.sleep(1.0))
        result = await asyncio.to_thread(sum, [1, 2])
        assert not ticking.done()
        with pytest.raises(ZeroDivisionError):
            await asyncio.to_thread(divmod, 1, 0)
        ticking.cancel()
        return clock.now(), result

    assert clock.run(work(), virtual=True) == (0.0, 3)


def test_every_virtual_time_has_the_same_date() -> None:
    async def date_s() -> float:
        await asyncio.sleep(5.0)
        return clock.epoch_s()

    assert clock.run(date_s(), virtual=True) == clock.run(date_s(), virtual=True) > 1.7e9


async def test_the_real_clocks_date_is_the_walls() -> None:
    assert clock.epoch_s() + clock.now() == pytest.approx(clock.unix_time_s(), abs=1.0)

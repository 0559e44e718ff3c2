"""Temperatures as Linux tells them."""

import asyncio
import math
from pathlib import Path

import pytest

from companion.cli.thermometer import Thermometer, hottest_c


def zone(folder: Path, number: int, kind: str, temperature: str) -> None:
    path = folder / f"thermal_zone{number}"
    path.mkdir()
    (path / "type").write_text(kind + "\n")
    (path / "temp").write_text(temperature + "\n")


def test_the_hottest_processor_counts(tmp_path: Path) -> None:
    zone(tmp_path, 0, "cpu-thermal", "61234")
    zone(tmp_path, 1, "x86_pkg_temp", "72000")
    zone(tmp_path, 2, "battery", "99000")
    zone(tmp_path, 3, "soc", "none")
    assert hottest_c(tmp_path) == pytest.approx(72.0)


def test_where_nothing_is_told_nothing_is_known(tmp_path: Path) -> None:
    (tmp_path / "thermal_zone0").mkdir()
    assert math.isnan(hottest_c(tmp_path))
    assert math.isnan(hottest_c(tmp_path / "nowhere"))


async def test_it_is_read_again_and_again(tmp_path: Path) -> None:
    zone(tmp_path, 0, "cpu-thermal", "50000")
    thermometer = Thermometer(tmp_path)
    assert math.isnan(thermometer.celsius)
    reading = asyncio.create_task(thermometer.keep_reading())
    async with asyncio.timeout(10.0):
        while math.isnan(thermometer.celsius):  # noqa: ASYNC110 (a thread tells it, not the loop)
            await asyncio.sleep(0.001)
    reading.cancel()
    assert thermometer.celsius == pytest.approx(50.0)

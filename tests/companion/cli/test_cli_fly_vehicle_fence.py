"""`companion fly` on vehicles whose parameters limit how far they go, from the file to what is refused."""

import re
from pathlib import Path

import pytest
import yaml
from command_line import Run

from companion.bundled import config_directory

PX4 = ("bebop2", "px4_parameters", {"GF_MAX_HOR_DIST": 4.0, "GF_MAX_VER_DIST": 6.0})
COPTER = (
    "arducopter_sitl",
    "ardupilot_parameters",
    {"FENCE_ENABLE": 1, "FENCE_RADIUS": 30.0, "FENCE_ALT_MAX": 10.0, "FENCE_MARGIN": 4.0},
)
FLOOR = (
    "arducopter_sitl",
    COPTER[1],
    {"FENCE_ENABLE": 1, "FENCE_TYPE": 8, "FENCE_ALT_MIN": 1, "FENCE_MARGIN": 1},
)


@pytest.fixture
def limited(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The address of a built-in vehicle with these parameters."""
    name, section, parameters = request.param
    described = yaml.safe_load((config_directory() / "vehicles" / f"{name}.yaml").read_text())
    described[section] = described.get(section, {}) | parameters
    file = tmp_path / f"{name}.yaml"
    file.write_text(yaml.safe_dump(described))
    return f"sitl://{file}"


@pytest.mark.parametrize(
    ("limited", "drawn", "told"),
    [
        (PX4, ("--size", 9, "--plane", "xy"), r"m beyond what the vehicle's GF_MAX_HOR_DIST 4 allows"),
        (PX4, ("--size", 5.5), r"m beyond what the vehicle's GF_MAX_VER_DIST 6 allows, which is kept 0\.5 m"),
        (
            COPTER,
            ("--origin", 26, 0),
            r"m beyond what the vehicle's FENCE_RADIUS 30 allows, which is kept 4 m",
        ),
        (FLOOR, (), r"m beyond what the vehicle's FENCE_ALT_MIN 1 allows, which is kept 1 m away from"),
        (COPTER, ("--size", 7), r"m beyond what the vehicle's FENCE_ALT_MAX 10 allows"),
    ],
    indirect=["limited"],
)
def test_what_leads_beyond_is_refused_before_takeoff(
    limited: str, drawn: tuple[object, ...], told: str, companion: Run
) -> None:
    ran = companion("fly", "star", "--connect", limited, "--strategy", "baseline", *drawn)
    assert ran.status == 2
    assert re.search(told, ran.err.replace("\n", " ")), ran.err
    assert "arming" not in ran.out


@pytest.mark.parametrize(
    ("limited", "told"),
    [
        (
            PX4,
            "within 3.5 m of the takeoff point (GF_MAX_HOR_DIST 4), "
            "at most 5.5 m above it (GF_MAX_VER_DIST 6)",
        ),
        (
            COPTER,
            "within 26 m of the takeoff point (FENCE_RADIUS 30), at most 6 m above it (FENCE_ALT_MAX 10)",
        ),
    ],
    indirect=["limited"],
)
def test_what_stays_within_is_flown(limited: str, told: str, companion: Run, tmp_path: Path) -> None:
    record = tmp_path / "flight.mcap"
    ran = companion("fly", "star", "--connect", limited, "--strategy", "baseline", "--record", record)
    assert ran.status == 0, ran.err
    assert f"the vehicle's own limits are kept to: {told}" in ran.out
    assert "breach" not in ran.out.lower()
    assert "violation" not in ran.out.lower()
    replayed = companion("replay", record)
    assert replayed.status == 0, replayed.out


@pytest.mark.parametrize(
    "limited",
    [
        ("bebop2", "px4_parameters", {"GF_MAX_VER_DIST": 2.5}),
        ("arducopter_sitl", *COPTER[1:2], COPTER[2] | {"FENCE_MARGIN": 8.0}),
    ],
    indirect=True,
)
def test_a_takeoff_leads_no_higher_than_the_ceiling(limited: str, companion: Run, tmp_path: Path) -> None:
    low = tmp_path / "low.csv"
    low.write_text("\n".join(["t,n,e,d", *(f"{t},{0.2 * t},0,-1.5" for t in range(6))]))
    ran = companion("fly", low, "--connect", limited, "--strategy", "baseline")
    assert ran.status == 0, ran.err
    assert "taking off to 2 m" in ran.out
    assert "breach" not in ran.out.lower()
    assert "violation" not in ran.out.lower()


@pytest.mark.parametrize("limited", [FLOOR], indirect=True)
def test_above_a_floor_it_is_flown_and_landed(limited: str, companion: Run) -> None:
    ran = companion(
        *("fly", "star", "--connect", limited, "--strategy", "baseline", "--altitude", 2.5, "--land")
    )
    assert ran.status == 0, ran.err
    assert "at least 2 m above it (FENCE_ALT_MIN 1)" in ran.out
    assert "breach" not in ran.out.lower()

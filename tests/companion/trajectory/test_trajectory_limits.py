import numpy as np
import pytest

from companion.arrays import Times, Vec3s
from companion.errors import InputError
from companion.trajectory.limits import Limits, Peaks, peaks_of, stretches
from companion.trajectory.trajectory import trajectory_of


def swing(times: Times) -> tuple[Vec3s, Vec3s, Vec3s]:
    """Two metres up and down at 3 rad/s: down = 2 sin 3t."""
    down = np.array([0.0, 0.0, 2.0])
    return (
        np.outer(np.sin(3 * times), down),
        np.outer(3 * np.cos(3 * times), down),
        np.outer(-9 * np.sin(3 * times), down),
    )


def test_peaks_of_a_sinusoid() -> None:
    peaks = peaks_of(trajectory_of("swing", 10.0, swing, step_s=0.02))
    assert peaks.speed_m_s == pytest.approx(6.0, rel=1e-4)
    assert peaks.acceleration_m_s2 == pytest.approx(18.0, rel=1e-4)
    assert peaks.jerk_m_s3 == pytest.approx(54.0, rel=1e-3)
    assert peaks.up_m_s == pytest.approx(6.0, rel=1e-4)
    assert peaks.down_m_s == pytest.approx(6.0, rel=1e-4)


def test_stretching_by_a_factor_reaches_its_limit() -> None:
    trajectory = trajectory_of("swing", 10.0, swing)
    allowed = Peaks(
        speed_m_s=3.0,
        acceleration_m_s2=2.0,
        jerk_m_s3=1.0,
        up_m_s=9.0,
        down_m_s=0.5,
        vertical_acceleration_m_s2=1.5,
    )
    for name, factor in stretches(peaks_of(trajectory), allowed).items():
        stretched = peaks_of(trajectory.stretched(factor))
        assert getattr(stretched, name) == pytest.approx(getattr(allowed, name))


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
@pytest.mark.parametrize("name", ["speed_m_s", "acceleration_m_s2", "jerk_m_s3", "up_m_s", "down_m_s"])
def test_limits_are_positive_numbers(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        Limits(**{name: value})


def test_the_usual_speed_stands_in_for_none() -> None:
    assert Limits().peaks(usual_speed_m_s=1.2).speed_m_s == 1.2
    assert Limits(speed_m_s=0.7).peaks(usual_speed_m_s=1.2).speed_m_s == 0.7


def test_limits_within_a_vehicle_leave_a_reserve() -> None:
    within = Limits(acceleration_m_s2=1.8).within_vehicle(
        up_m_s=2.5, down_m_s=1.5, acceleration_m_s2=2.5, vertical_acceleration_m_s2=1.0
    )
    assert (within.up_m_s, within.down_m_s) == pytest.approx((2.0, 1.2))
    assert within.acceleration_m_s2 == 1.8
    assert within.vertical_acceleration_m_s2 == pytest.approx(0.8)
    assert Limits().within_vehicle(up_m_s=3.75, down_m_s=1.875).peaks(1.0).acceleration_m_s2 == 4.0

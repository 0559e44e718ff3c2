"""The trajectories of a comparison, by name, within what its vehicles can do."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from companion import bundled
from companion.errors import InputError
from companion.experiments.lasa import BENCHMARK_NAMES, TUNING_NAMES, lasa_trajectory
from companion.flight.guard import GuardLimits
from companion.trajectory.limits import Limits, peaks_of
from companion.trajectory.placement import Placement
from companion.trajectory.readers import read_trajectory
from companion.trajectory.summary import summarise
from companion.trajectory.trajectory import Trajectory
from sitl.errors import ConfigError
from sitl.vehicle import MotionLimits, load_vehicle

_REACHED = 0.99
"""Share of the speed asked for that counts as it."""


@dataclass(frozen=True, eq=False)
class Course:
    """A drawing as it is to be flown.

    Attributes:
        drawing: its name.
        plane: in which it is laid.
        speed_m_s: the peak speed asked for (m/s); None leaves it to the kind of file.
        trajectory: NED relative to the takeoff point (m); its name is not that of any other course.
    """

    drawing: str
    plane: str
    speed_m_s: float | None
    trajectory: Trajectory

    @cached_property
    def reached_m_s(self) -> float:
        """Peak speed of the trajectory (m/s)."""
        return peaks_of(self.trajectory).speed_m_s


def courses(
    names: Sequence[str],
    placement: Placement,
    vehicles: Sequence[str],
    speeds_m_s: Sequence[float] = (),
) -> tuple[list[Course], list[str]]:
    """Each drawing at each speed (m/s), or at its kind's own, as far as the weakest vehicle can follow it.

    Returns:
        The courses, and a line for each that is slower than was asked for.

    Raises:
        InputError: see `limits_within` and `named_trajectories`.
    """
    flown, notes = list[Course](), list[str]()
    for speed_m_s in dict.fromkeys(speeds_m_s) or [None]:
        limits = limits_within(vehicles, speed_m_s)
        for trajectory in named_trajectories(names, placement, limits):
            drawing = trajectory.name
            if len(speeds_m_s) > 1:
                name = f"{drawing} at {speed_m_s:g} m/s"
                trajectory = Trajectory(name, trajectory.step_s, trajectory.coefficients)
            course = Course(drawing, placement.plane, speed_m_s, trajectory)
            flown.append(course)
            if speed_m_s is not None and course.reached_m_s < _REACHED * speed_m_s:
                bound_by = ", ".join(summarise(trajectory, limits).bound_by) or "its own times"
                notes.append(
                    f"{drawing}: {course.reached_m_s:.2f} m/s instead of {speed_m_s:g}: bound by {bound_by}"
                )
    return flown, notes


def limits_within(vehicles: Sequence[str], speed_m_s: float | None) -> Limits:
    """The limits with that peak speed (m/s), and what the weakest of the vehicles keeps to.

    Raises:
        InputError: a vehicle is missing or wrong, or the speed is not positive.
    """
    try:
        each = [load_vehicle(vehicle).motion_limits for vehicle in vehicles]
    except ConfigError as error:
        raise InputError(str(error)) from error
    weakest = MotionLimits(*map(min, zip(*each, strict=True)))
    return Limits(speed_m_s=speed_m_s).within_vehicle(**weakest._asdict())


def named_trajectories(names: Sequence[str], placement: Placement, limits: Limits) -> list[Trajectory]:
    """CSV files, drawings of `config/trajectories` and LASA shapes; each gets a name of its own.

    Raises:
        InputError: one of them is not there, cannot be flown, or leaves the guard's fence.
    """
    trajectories: dict[str, Trajectory] = {}
    for name in dict.fromkeys(names):
        trajectory = _named_trajectory(name, placement, limits)
        if trajectory.name in trajectories:
            trajectory = Trajectory(name, trajectory.step_s, trajectory.coefficients)
        GuardLimits().fence.require_inside(trajectory)
        trajectories[trajectory.name] = trajectory
    return list(trajectories.values())


def _named_trajectory(name: str, placement: Placement, limits: Limits) -> Trajectory:
    if name in BENCHMARK_NAMES + TUNING_NAMES and not Path(name).is_file():
        return lasa_trajectory(name, placement, limits)
    try:
        path = bundled.find("trajectories", name, ".csv")
    except InputError as error:
        raise InputError(f"{error}; LASA shapes: {', '.join(BENCHMARK_NAMES + TUNING_NAMES)}") from error
    return read_trajectory(path, placement, limits)

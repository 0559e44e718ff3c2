"""The trajectories of a comparison, by name, within what its vehicles can do."""

from collections.abc import Sequence
from pathlib import Path

from companion import bundled
from companion.errors import InputError
from companion.experiments.lasa import BENCHMARK_NAMES, TUNING_NAMES, lasa_trajectory
from companion.flight.guard import GuardLimits
from companion.trajectory.limits import Limits
from companion.trajectory.placement import Placement
from companion.trajectory.readers import read_trajectory
from companion.trajectory.trajectory import Trajectory
from sitl.errors import ConfigError
from sitl.vehicle import MotionLimits, load_vehicle


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

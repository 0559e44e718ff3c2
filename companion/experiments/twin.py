"""A recorded flight flown again by a simulated vehicle: the same setpoints at the same instants."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation, Slerp

from companion.arrays import Array, Times, Vec3
from companion.errors import InputError
from companion.recording.segments import Window
from companion.recording.series import Recording, ReferenceSeries, StateSeries, rows
from sitl.conditions import Conditions
from sitl.errors import ConfigError
from sitl.estimator_errors import EstimatorErrors
from sitl.firmware.interface import Estimate, Setpoint
from sitl.plant import TICK_S
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle, load_vehicle

_ORIGIN = np.array((0.0, 0.0, -100.0))
"""Where the twin begins, wherever the recording did: far from the simulated ground."""


def fly_twin(
    vehicle: Vehicle,
    recording: Recording,
    window: Window,
    *,
    errors: EstimatorErrors | None = None,
    seed: int = 0,
) -> StateSeries:
    """What the vehicle makes of recorded setpoints, beginning in the state recorded at the window's start.

    Args:
        vehicle: the twin.
        recording: of a flight; a setpoint acts at its `time_s`.
        window: of the recording's clock; what was last sent before it is what the twin begins with.
        errors: of the twin's estimate; the vehicle's own without noise and wander when None.
        seed: of these errors.

    Returns:
        The twin's own estimate, every 10 ms, on the recording's clock and in its NED frame.

    Raises:
        InputError: no state, or no setpoint, was recorded at the window's start.
    """
    motion = motion_at(recording.states, window.start_s)
    shift = _ORIGIN - motion[:3]
    motion[:3] = _ORIGIN
    if errors is None:
        errors = without_noise(vehicle.estimator or EstimatorErrors())
    simulation = Simulation(vehicle, Conditions(name="twin", estimator=errors), seed=seed, motion=motion)
    sent = recording.references
    following = np.searchsorted(sent.time_s, window.start_s, side="right")
    if following == 0:
        raise InputError(
            f"nothing was sent before {window.start_s:.1f} s: a twin needs a setpoint to begin with"
        )
    following -= 1
    estimates: list[Estimate] = []
    for tick in range(int((window.end_s - window.start_s) / TICK_S) + 1):
        now_s = window.start_s + tick * TICK_S
        while following < len(sent.time_s) and sent.time_s[following] <= now_s:
            simulation.firmware.offboard_setpoint(setpoint(sent, int(following), shift))
            following += 1
        estimates.append(simulation.firmware.estimate)
        simulation.advance((tick + 1) * TICK_S)
    flown = state_series(estimates, window.start_s)
    return replace(flown, position=flown.position - shift)


def twin_vehicle(name_or_path: str) -> Vehicle:
    """A vehicle by its name in `config/vehicles`, or from a YAML file.

    Raises:
        InputError: there is none, or its file is wrong.
    """
    try:
        return load_vehicle(name_or_path)
    except ConfigError as error:
        raise InputError(str(error)) from error


def motion_at(states: StateSeries, time_s: float) -> Float[Array, "13"]:
    """Position, velocity, attitude (quaternion) and body rates at an instant, linear between two states.

    Raises:
        InputError: the recording has no states around it.
    """
    after = int(np.searchsorted(states.time_s, time_s))
    if not 0 < after < len(states.time_s):
        raise InputError(f"no state was recorded at {time_s:.1f} s")
    around = rows(states, np.array((after - 1, after)))
    turning = Slerp(around.time_s, Rotation.from_euler("ZYX", around.attitude[:, ::-1]))
    x, y, z, w = turning(time_s).as_quat()
    position, velocity, rates = (
        at_times(np.array([time_s]), around.time_s, values)[0]
        for values in (around.position, around.velocity, around.rates)
    )
    return np.concatenate((position, velocity, (w, x, y, z), rates))


def at_times(time_s: Times, known_s: Times, values: Float[Array, "n k"]) -> Float[Array, "m k"]:
    """Columns of `values`, known at `known_s`, at other times, linear in between."""
    return np.column_stack([np.interp(time_s, known_s, column) for column in values.T])


def setpoint(sent: ReferenceSeries, row: int, shift: Vec3) -> Setpoint:
    """A reference as the firmware takes it, its position moved by `shift` (m)."""
    return Setpoint(
        sent.position[row] + shift, sent.velocity[row], sent.acceleration[row], yaw=float(sent.yaw[row])
    )


def without_noise(errors: EstimatorErrors) -> EstimatorErrors:
    """Only the delays of an estimator."""
    delays = {
        name: {"delay_s": getattr(errors, name).delay_s}
        for name in ("position", "velocity", "attitude", "rates")
    }
    return EstimatorErrors.model_validate(delays)


def state_series(estimates: Sequence[Estimate], start_s: float) -> StateSeries:
    """Estimates of one tick after another, the first at `start_s` (s)."""
    quaternions = np.array([estimate.attitude for estimate in estimates])
    return StateSeries(
        time_s=start_s + TICK_S * np.arange(len(estimates), dtype=float),
        position=np.array([estimate.position for estimate in estimates]),
        velocity=np.array([estimate.velocity for estimate in estimates]),
        attitude=Rotation.from_quat(quaternions[:, [1, 2, 3, 0]]).as_euler("ZYX")[:, ::-1],
        rates=np.array([estimate.rates for estimate in estimates]),
    )

"""ArduPilot's fast loop, compiled: filters, rates, motors, path, position and attitude.

The sensors are read at 1 kHz, the loop itself runs at ArduPilot's 400 Hz (SCHED_LOOP_RATE), which is every
second or third step of the plant. As there, the motors act on the attitude command of the loop before.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Quaternion, Vec3
from sitl.compiled import compiled
from sitl.estimator import Estimator
from sitl.firmware.ardupilot_attitude import (
    AttitudeGains,
    AttitudeState,
    RateGains,
    attitude_gains,
    attitude_state,
    begin_attitude,
    control_attitude,
    control_rates,
    lean_towards,
    rate_gains,
    shape_attitude,
)
from sitl.firmware.ardupilot_motors import Mixer, MotorLimits, mix, mixer
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.ardupilot_path import Follow, Path, PathLimits, Target, path, path_limits, shape_path
from sitl.firmware.ardupilot_pid import LowPass, blend, low_pass, settle, smooth
from sitl.firmware.ardupilot_position import (
    PositionGains,
    PositionState,
    begin_position,
    control_horizontal,
    control_vertical,
    position_gains,
    position_state,
)
from sitl.plant import STEP_S, STEPS_PER_TICK, Plant, TickNoise, begin_tick, end_tick, step
from sitl.quaternion import rotate, yaw_of
from sitl.vehicle import Vehicle

LOOP_S = 0.0025
_THROTTLE_HZ = 2.0
"""Low pass of the throttle (POSCONTROL_THROTTLE_CUTOFF_FREQ_HZ)."""
_LOOK_AHEAD_SHARE = 0.05
"""Share of the horizontal speed limit above which the nose may follow the path."""


class Sensors(NamedTuple):
    """Filtered inertial sensors, in place.

    Attributes:
        gyro: INS_GYRO_FILTER on roll, pitch and yaw rate. accelerometer: INS_ACCEL_FILTER, downwards.
        rates: rad/s.
        down: last vertical velocity (m/s), filtered vertical acceleration (m/s²).
    """

    gyro: LowPass
    accelerometer: LowPass
    rates: Vec3
    down: Float[Array, "2"]


class Loops(NamedTuple):
    """Gains and memory of everything that runs at 400 Hz.

    Attributes:
        throttle: filtered throttle with the boost for lean (0 to 1).
        thrusts: of the rotors, held between two loops.
        headroom: share of the hover throttle that the mean thrust may rise by for roll and pitch.
    """

    limits: PathLimits
    path: Path
    position: PositionGains
    position_state: PositionState
    attitude: AttitudeGains
    rates: RateGains
    attitude_state: AttitudeState
    mixer: Mixer
    motor_limits: MotorLimits
    sensors: Sensors
    throttle: Float[Array, "1"]
    thrusts: Float[Array, " n"]
    headroom: float


def new_loops(vehicle: Vehicle, p: ArduPilotParameters) -> Loops:
    """At rest on the ground, with gains from ArduPilot parameters."""
    sensors = Sensors(
        gyro=low_pass(3, p.INS_GYRO_FILTER, STEP_S),
        accelerometer=low_pass(1, p.INS_ACCEL_FILTER, STEP_S),
        rates=np.zeros(3),
        down=np.zeros(2),
    )
    return Loops(
        limits=path_limits(p),
        path=path(),
        position=position_gains(p),
        position_state=position_state(p.MOT_THST_HOVER),
        attitude=attitude_gains(p),
        rates=rate_gains(p),
        attitude_state=attitude_state(),
        mixer=mixer(vehicle, 0.001 * p.MOT_YAW_HEADROOM),
        motor_limits=np.zeros(4, dtype=np.bool_),
        sensors=sensors,
        throttle=np.zeros(1),
        thrusts=np.zeros(len(vehicle.rotors.layout)),
        headroom=p.ATC_THR_MIX_MAX,
    )


@compiled
def start_sensors(sensors: Sensors, rates: Vec3, down: float) -> None:
    """Let the filters have seen these rates (rad/s) and this vertical velocity (m/s) all the time."""
    for axis in range(3):
        settle(sensors.gyro, axis, rates[axis])
        sensors.rates[axis] = rates[axis]
    settle(sensors.accelerometer, 0, 0.0)
    sensors.down[0], sensors.down[1] = down, 0.0


@compiled
def sense(sensors: Sensors, rates: Vec3, down: float) -> None:
    """Take in one sample of the body rates (rad/s) and of the true vertical velocity (m/s).

    The derivative of the latter is what an accelerometer shows, which has no wander to speak of.
    """
    for axis in range(3):
        sensors.rates[axis] = smooth(sensors.gyro, axis, rates[axis])
    sensors.down[1] = smooth(sensors.accelerometer, 0, (down - sensors.down[0]) / STEP_S)
    sensors.down[0] = down


@compiled
def begin_control(loops: Loops, estimate: Estimator) -> None:
    """Begin position control where the vehicle is, with the lean and the throttle that it has."""
    begin_position(
        loops.position,
        loops.position_state,
        loops.path,
        estimate.position,
        estimate.velocity,
        loops.sensors.down[1],
    )


@compiled
def run_motors(loops: Loops) -> None:
    """Rate control and mixing: new rotor thrusts."""
    short = loops.motor_limits
    output = control_rates(loops.rates, loops.attitude_state, loops.sensors.rates, short[0], short[1], LOOP_S)
    hover, throttle = loops.position_state.scalars[1], loops.throttle[0]
    highest = max(throttle, hover * loops.headroom + throttle * (1.0 - loops.headroom))
    thrusts = mix(loops.mixer, output, throttle, highest, short)
    for i in range(thrusts.size):
        loops.thrusts[i] = thrusts[i]


@compiled
def boost(throttle: float, attitude: Quaternion) -> float:
    """Throttle that keeps the vertical thrust at this lean; less beyond 60°, none upside down."""
    upright = -rotate(attitude, (0.0, 0.0, -1.0))[2]
    return throttle * min(max(10.0 * upright, 0.0), 1.0) / min(max(upright, 0.1), 1.0)


@compiled
def filter_throttle(loops: Loops, throttle: float) -> None:
    """Move the filtered throttle towards `throttle`."""
    loops.throttle[0] += blend(_THROTTLE_HZ, LOOP_S) * (min(max(throttle, 0.0), 1.0) - loops.throttle[0])


@compiled
def point(loops: Loops, goal: Target, attitude: Quaternion) -> None:
    """Attitude command: lean as the position controller wants, nose where the target has it."""
    state, now = loops.attitude_state, loops.path
    goal.heading[0] += goal.heading[1] * LOOP_S
    yaw, rate = goal.heading[0], goal.heading[1]
    turns = False
    if math.isnan(yaw):
        turns = not math.isnan(rate)
        vx, vy = now.velocity[0], now.velocity[1]
        if not turns:
            rate = 0.0
        if not turns and math.hypot(vx, vy) > _LOOK_AHEAD_SHARE * loops.limits.speed:
            yaw = math.atan2(vy, vx)
            rate = (vx * now.acceleration[1] - vy * now.acceleration[0]) / (vx**2 + vy**2)
        else:
            yaw = yaw_of(state.target)
    elif math.isnan(rate):
        rate = 0.0
    wanted = lean_towards(loops.position_state.wanted, yaw)
    shape_attitude(loops.attitude, state, wanted, rate, turns, LOOP_S)
    control_attitude(loops.attitude, state, attitude, loops.sensors.rates, LOOP_S)


@compiled
def fly_loop(loops: Loops, goal: Target, estimate: Estimator, down_unlimited: bool) -> None:
    """One loop in flight: motors, then the commands for the next; `down_unlimited`: press onto the ground."""
    run_motors(loops)
    short = loops.motor_limits
    limit = 0.0
    if short[3]:
        limit = -1.0
    elif short[2]:
        limit = 1.0
    if down_unlimited and limit > 0.0:
        loops.path.limit[2] = 0.0
    shape_path(loops.limits, goal, loops.path, LOOP_S)
    if goal.follow[0] == Follow.LEVEL:
        loops.position_state.wanted[0] = loops.position_state.wanted[1] = 0.0
    else:
        control_horizontal(
            loops.position, loops.position_state, loops.path, estimate.position, estimate.velocity, LOOP_S
        )
    control_vertical(
        loops.position,
        loops.position_state,
        loops.path,
        estimate.position[2],
        estimate.velocity[2],
        loops.sensors.down[1],
        limit,
        LOOP_S,
    )
    point(loops, goal, estimate.attitude)
    filter_throttle(loops, boost(loops.position_state.scalars[0], estimate.attitude))


@compiled
def rest_loop(loops: Loops, estimate: Estimator, throttle: float) -> None:
    """One loop on the ground: nothing integrated, all rotors at `throttle`, ready to begin from there."""
    begin_attitude(loops.attitude_state, estimate.attitude, loops.sensors.rates)
    for axis in range(3):
        loops.position_state.wanted[axis] = 0.0
    loops.position_state.scalars[0] = loops.throttle[0] = throttle
    for i in range(loops.thrusts.size):
        loops.thrusts[i] = throttle
    begin_control(loops, estimate)


@compiled
def fly_tick(
    plant: Plant,
    estimate: Estimator,
    loops: Loops,
    goal: Target,
    armed: bool,
    open_throttle: float,
    down_unlimited: bool,
    first_step: int,
    noise: TickNoise,
) -> None:
    """Advance plant and estimate by one tick towards `goal`, in place.

    `open_throttle` is the throttle on the ground, NaN in flight. A landing vehicle goes `down_unlimited`: it
    does not stop its descent at the least throttle. `first_step` counts steps since boot.
    """
    top_speed = begin_tick(plant, estimate, noise)
    for i in range(STEPS_PER_TICK):
        number = first_step + i
        sense(loops.sensors, estimate.rates, plant.body.motion[5])
        if 2 * number % 5 < 2:
            if math.isnan(open_throttle):
                fly_loop(loops, goal, estimate, down_unlimited)
            else:
                rest_loop(loops, estimate, open_throttle)
        step(plant, estimate, loops.thrusts, armed, top_speed, number, noise.estimate[i])
    end_tick(plant)

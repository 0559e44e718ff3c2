"""ArduPilot's loops from outside: their estimate, and what parameters, a start in flight or hover change."""

import math

import numpy as np

from sitl.estimator import Estimator
from sitl.firmware.ardupilot_attitude import attitude_gains, begin_attitude, rate_gains
from sitl.firmware.ardupilot_loops import Loops, begin_control, start_sensors
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.ardupilot_path import path_limits
from sitl.firmware.ardupilot_position import learn_hover, position_gains
from sitl.firmware.interface import Estimate
from sitl.plant import TICK_S

_HOVER_LEARNING_S = 10.0
_HOVERING_M_S = 0.6
_HOVERING_TILT = math.radians(5.0)


def with_parameters(loops: Loops, p: ArduPilotParameters) -> Loops:
    """The same loops, by other parameters."""
    return loops._replace(
        limits=path_limits(p),
        position=position_gains(p),
        attitude=attitude_gains(p),
        rates=rate_gains(p),
        mixer=loops.mixer._replace(yaw_headroom=0.001 * p.MOT_YAW_HEADROOM),
        headroom=p.ATC_THR_MIX_MAX,
    )


def with_speed(loops: Loops, p: ArduPilotParameters, speed_m_s: float) -> Loops:
    """The same loops, keeping to a ground speed (m/s); WPNAV_SPEED for 0 and below."""
    limits = path_limits(p)
    return loops._replace(limits=limits._replace(speed=speed_m_s) if speed_m_s > 0.0 else limits)


def begin_hovering(loops: Loops, estimate: Estimator) -> None:
    """Let the loops be as if they had flown so far as the estimate says, in place."""
    start_sensors(loops.sensors, estimate.rates, float(estimate.velocity[2]))
    begin_attitude(loops.attitude_state, estimate.attitude, estimate.rates)
    hover = loops.position_state.scalars[1]
    loops.throttle[0] = loops.position_state.scalars[0] = hover
    loops.thrusts[:] = hover
    begin_control(loops, estimate)


def learn_while_hovering(loops: Loops, estimate: Estimator) -> None:
    """Take the throttle of slow and level flight for that of hover, little by little, in place."""
    throttle = float(loops.throttle[0])
    tilt = 2.0 * math.asin(min(1.0, math.hypot(estimate.attitude[1], estimate.attitude[2])))
    if abs(estimate.velocity[2]) < _HOVERING_M_S and tilt < _HOVERING_TILT and throttle > 0.0:
        learn_hover(loops.position_state, throttle, TICK_S, _HOVER_LEARNING_S)


def estimate_now(loops: Loops, estimator: Estimator, time_s: float) -> Estimate:
    """A copy of the estimate, with the acceleration that the loops make of it."""
    wanted = loops.position_state.wanted
    return Estimate(
        time_s=time_s,
        position=estimator.position.copy(),
        velocity=estimator.velocity.copy(),
        acceleration=np.array((wanted[0], wanted[1], loops.sensors.down[1])),
        attitude=estimator.attitude.copy(),
        rates=estimator.rates.copy(),
        gps=estimator.gps.copy(),
        resets=int(estimator.resets[0]),
        test_ratios=(float(estimator.test_ratios[0]), float(estimator.test_ratios[1])),
    )

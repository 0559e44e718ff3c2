"""What flies a PX4 below its modes: takeoff phases, position control at 100 Hz, and the loops under it."""

import math

from sitl.arrays import Vec3
from sitl.estimator import Estimator
from sitl.firmware.interface import AttitudeTarget, Estimate, Setpoint
from sitl.firmware.pilot import Sticks
from sitl.firmware.px4_allocation import allocation
from sitl.firmware.px4_attitude import attitude_gains, begin_turning, rate_gains, rate_state
from sitl.firmware.px4_hover_thrust import HoverThrust
from sitl.firmware.px4_inner_loops import InnerLoops, fly_tick
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.firmware.px4_position import (
    PositionLimits,
    attitude_setpoint,
    change_hover_thrust,
    control_position,
    position_gains,
    position_setpoint,
    position_state,
)
from sitl.firmware.px4_takeoff import Takeoff, TakeoffPhase
from sitl.plant import TICK_S, Plant, TickNoise
from sitl.quaternion import yaw_of
from sitl.vehicle import Vehicle

_CLEAR_OF_GROUND_M = 1.0
"""The hover thrust is learnt above this height only."""
_NO_THRUST_M_S2 = 100.0
"""Downward acceleration setpoint that leaves no thrust."""


class Control:
    """Turns `setpoint` and the estimate into what the rotors do.

    Attributes:
        setpoint: what is followed; whoever decides writes it.
        takeoff: the phase, and the limits that follow from it.
    """

    def __init__(self, vehicle: Vehicle, parameters: Px4Parameters, estimator: Estimator) -> None:
        self.setpoint = position_setpoint()
        self.takeoff = Takeoff(parameters)
        self._parameters = parameters
        self._estimator = estimator
        self._gains = position_gains(parameters)
        self._state = position_state()
        self._attitude_setpoint = attitude_setpoint()
        self._loops = InnerLoops(
            attitude_gains(parameters), rate_gains(parameters), rate_state(), allocation(vehicle)
        )
        self._learnt = HoverThrust(parameters)
        self._hover_thrust = parameters.MPC_THR_HOVER
        self._true_hover_thrust = vehicle.hover_thrust

    def use(self, parameters: Px4Parameters) -> None:
        """Go by these from now on; what was integrated and learnt stays."""
        self._parameters = parameters
        self._gains = position_gains(parameters)
        self._loops = self._loops._replace(attitude=attitude_gains(parameters), rates=rate_gains(parameters))
        self.takeoff.use(parameters)
        self._learnt.use(parameters)

    @property
    def acceleration(self) -> Vec3:
        """Derivative of the estimated velocity, NED (m/s²)."""
        return self._state.acceleration

    def estimate(self, time_s: float) -> Estimate:
        """A copy of the estimate at this time (s)."""
        e = self._estimator
        return Estimate(
            time_s=time_s,
            position=e.position.copy(),
            velocity=e.velocity.copy(),
            acceleration=self.acceleration.copy(),
            attitude=e.attitude.copy(),
            rates=self.rates.copy(),
            gps=e.gps.copy(),
            resets=int(e.resets[0]),
            test_ratios=(float(e.test_ratios[0]), float(e.test_ratios[1])),
        )

    @property
    def active_setpoint(self) -> Setpoint:
        """A copy of `setpoint`."""
        s = self.setpoint
        return Setpoint(
            position=s.position.copy(),
            velocity=s.velocity.copy(),
            acceleration=s.acceleration.copy(),
            yaw=float(s.heading[0]),
            yaw_rate=float(s.heading[1]),
        )

    @property
    def rates(self) -> Vec3:
        """Body rates as the rate controller sees them (rad/s)."""
        rates: Vec3 = self._loops.state.rates[0]
        return rates

    @property
    def attitude_target(self) -> AttitudeTarget:
        """What attitude and rate control follow."""
        return AttitudeTarget(
            self._attitude_setpoint.attitude.copy(), self._loops.state.setpoint.copy(), self.thrust
        )

    @property
    def thrust(self) -> float:
        """Commanded collective thrust (0 to 1)."""
        return float(self._attitude_setpoint.thrust_and_yaw_rate[0])

    def begin_in_flight(self) -> None:
        """Fly already, in the estimated motion, and for long enough to know the hover thrust."""
        self.takeoff.skip()
        self._state.velocity[:] = self._estimator.velocity
        begin_turning(self._loops.state, self._estimator.rates)
        self._learnt.settle(self._true_hover_thrust)
        if self._parameters.MPC_USE_HTE:
            self._hover_thrust = self._learnt.estimate
        change_hover_thrust(self._state, self._true_hover_thrust, self._hover_thrust)

    def stay_down(self) -> None:
        """Ask for no thrust, and let nothing integrate."""
        self._state.integral[:] = 0.0
        s = self.setpoint
        s.position[:] = s.velocity[:] = s.heading[:] = math.nan
        s.acceleration[:] = (0.0, 0.0, _NO_THRUST_M_S2)

    def follow_setpoint(self, wanted: Setpoint) -> None:
        """Ask for what came from outside; a takeoff's ramp leaves out what would contradict it."""
        s = self.setpoint
        s.position[:] = wanted.position
        s.velocity[:] = wanted.velocity
        s.acceleration[:] = wanted.acceleration
        s.heading[:] = (wanted.yaw, wanted.yaw_rate)
        if self.takeoff.phase is TakeoffPhase.RAMPUP and math.isfinite(wanted.velocity[2]):
            s.acceleration[2] = math.nan

    def follow_sticks(self, sticks: Sticks, max_up: float) -> None:
        """Ask for what the pilot wants, climbing at most at `max_up` (m/s)."""
        p, s = self._parameters, self.setpoint
        heading = yaw_of(self._estimator.attitude)
        s.position[:] = s.acceleration[:] = math.nan
        s.velocity[:] = sticks.velocity(heading, p.MPC_VEL_MANUAL, max_up, p.MPC_Z_VEL_MAX_DN)
        s.heading[:] = math.nan, math.radians(p.MPC_MAN_Y_MAX) * sticks.yaw

    def descend_level(self) -> None:
        """Ask for level flight and a slow descent, wherever the wind carries that."""
        s = self.setpoint
        s.position[:] = s.velocity[:] = s.acceleration[:] = s.heading[:] = math.nan
        s.velocity[2] = self._parameters.MPC_LAND_SPEED
        s.acceleration[0] = s.acceleration[1] = 0.0

    def jump(self, velocity: Vec3) -> None:
        """The estimated velocity jumped by this (m/s), which is no acceleration."""
        self._state.velocity[:] += velocity

    def follow(self, max_up: float, *, armed: bool, on_ground: bool) -> None:
        """One step of the position controller, climbing at most at `max_up` (m/s)."""
        p, e, takeoff = self._parameters, self._estimator, self.takeoff
        flying = takeoff.phase is TakeoffPhase.FLIGHT
        self._choose_hover_thrust(flying)
        limits = PositionLimits(
            max_up=max_up,
            max_tilt=takeoff.max_tilt,
            min_thrust=p.MPC_THR_MIN if flying else 0.0,
            hover_thrust=self._hover_thrust,
        )
        control_position(
            self._gains,
            limits,
            self._state,
            self.setpoint,
            e.position,
            e.velocity,
            e.attitude,
            TICK_S,
            self._attitude_setpoint,
        )
        self._learn_hover_thrust(armed, on_ground)

    def fly_tick(
        self, plant: Plant, first_step: int, noise: TickNoise, *, armed: bool, on_ground: bool
    ) -> None:
        """The inner loops with the plant, for one tick."""
        fly_tick(
            plant, self._estimator, self._loops, self._attitude_setpoint, armed, on_ground, first_step, noise
        )

    def _choose_hover_thrust(self, flying: bool) -> None:
        p = self._parameters
        if not flying:
            self._hover_thrust = p.MPC_THR_HOVER
        elif p.MPC_USE_HTE and self._learnt.valid:
            change_hover_thrust(self._state, self._hover_thrust, self._learnt.estimate)
            self._hover_thrust = self._learnt.estimate

    def _learn_hover_thrust(self, armed: bool, on_ground: bool) -> None:
        if not armed:
            self._learnt.reset()
        if on_ground or self._estimator.position[2] > -_CLEAR_OF_GROUND_M:
            return
        q = self._attitude_setpoint.attitude
        self._learnt.update(
            climb_acceleration=-float(self._state.acceleration[2]),
            thrust=self.thrust * float(1.0 - 2.0 * (q[1] ** 2 + q[2] ** 2)),
            velocity=self._estimator.velocity,
            dt=TICK_S,
        )

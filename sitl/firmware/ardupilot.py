"""A simulated ArduPilot Copter: modes, arming, takeoff, landing, failsafes, and the controllers behind them.

Behaviour follows ArduPilot's documentation (https://ardupilot.org/copter/docs/flight-modes.html and
https://ardupilot.org/copter/docs/arming_the_motors.html) as far as flying from a companion needs.
"""

import numpy as np

from sitl.arrays import Vec3
from sitl.battery import Pack
from sitl.estimator import STEPS_PER_S, Estimator
from sitl.firmware.ardupilot_failsafes import Links, LowBattery
from sitl.firmware.ardupilot_flight import (
    begin_hovering,
    estimate_now,
    learn_while_hovering,
    with_parameters,
    with_speed,
)
from sitl.firmware.ardupilot_guidance import Guidance
from sitl.firmware.ardupilot_loops import begin_control, fly_tick, new_loops
from sitl.firmware.ardupilot_modes import EQUIVALENTS, MODE_NAMES, reason_not_to_enter
from sitl.firmware.ardupilot_navigator import Navigator
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.ardupilot_takeoff import Phase, Takeoff
from sitl.firmware.ardupilot_tuning import tuned_parameters
from sitl.firmware.commander import Commander
from sitl.firmware.interface import AttitudeTarget, Estimate, Landed, Mode, Result, Setpoint, Severity
from sitl.plan.items import PlanKind
from sitl.plant import STEPS_PER_TICK, TICK_S, Plant, TickNoise
from sitl.quaternion import yaw_of
from sitl.vehicle import Vehicle

_TOTALS = {PlanKind.MISSION: "MIS_TOTAL", PlanKind.FENCE: "FENCE_TOTAL", PlanKind.RALLY: "RALLY_TOTAL"}
_MODES_TO_ARM_IN = frozenset((Mode.STABILIZE, Mode.HOLD, Mode.OFFBOARD))


class ArduPilot(Commander[ArduPilotParameters]):
    """Implements `interface.Firmware`; GUIDED is `Mode.OFFBOARD`, LOITER is `Mode.HOLD`.

    Attributes:
        failsafe: whether a failsafe chose the present mode.
    """

    dead_reckons_s = 11.0
    """EKF3 aids itself for 10 s, and ekf_check.cpp waits for another."""
    _guidance: Guidance

    def __init__(self, vehicle: Vehicle, estimator: Estimator, pack: Pack) -> None:
        super().__init__(tuned_parameters(vehicle), estimator, pack, Mode.STABILIZE)
        self._loops = new_loops(vehicle, self._parameters)
        self._guidance = Guidance(self._parameters, self._loops.path)
        self._takeoff = Takeoff(self._parameters)
        self.failsafe = False
        self._low_battery = LowBattery()
        self._links = Links()
        self._climbs_to: float | None = None
        self._setpoint_at_s: float | None = None
        self._navigator = Navigator(
            self._parameters,
            estimator,
            self._loops.path,
            self._guidance,
            lift_off=self._lift_off,
            set_speed=self.change_speed,
            enable_fence=lambda enabled: self.enable_fence(enabled=enabled),
            count_items=self._count_items,
            say=self._say,
        )
        self.plans, self._fence = self._navigator.plans, self._navigator.fence

    # What it reports

    @property
    def estimate(self) -> Estimate:
        """A copy of the estimate of this instant."""
        return estimate_now(self._loops, self._estimator, self._time_s)

    @property
    def active_setpoint(self) -> Setpoint:
        """What the position controller follows now, in any mode."""
        return self._guidance.setpoint

    @property
    def attitude_target(self) -> AttitudeTarget:
        """What attitude and rate control follow now."""
        state = self._loops.attitude_state
        return AttitudeTarget(state.target.copy(), state.rates.copy(), float(self._loops.throttle[0]))

    @property
    def landed(self) -> Landed:
        """As the land detector has it."""
        if not self._in_flight:
            return Landed.ON_GROUND
        if self._navigator.lands:
            return Landed.LANDING
        return Landed.IN_AIR if self._climbs_to is None else Landed.TAKING_OFF

    # What it is asked

    def set_parameter(self, name: str, value: float) -> None:
        """Fly by another value from now on; see `interface.Autopilot`."""
        self._parameters = p = self._parameters.changed(name, value)
        self._loops = with_parameters(self._loops, p)
        self._guidance.use(p)
        self._navigator.use(p)
        self._takeoff.use(p)

    def arm(self, *, force: bool = False) -> Result:
        """Arm, unless a check refuses; the reason is a status text."""
        if self._armed:
            return Result.ACCEPTED
        reason = None if force else self._reason_not_to_arm()
        if reason is not None:
            self._say(Severity.CRITICAL, f"Arm: {reason}")
            return Result.FAILED
        self._armed = True
        self._takeoff.enter(Phase.GROUND)
        self._navigator.begin_flight()
        self._say(Severity.INFO, "Arming motors")
        return Result.ACCEPTED

    def check(self) -> Result:
        """Tell what would keep it from arming in a suitable mode."""
        if self._armed:
            return Result.TEMPORARILY_REJECTED
        reason = self._failed_check()
        if reason is not None:
            self._say(Severity.CRITICAL, f"PreArm: {reason}")
        return Result.ACCEPTED

    def disarm(self, *, force: bool = False) -> Result:
        """Disarm on the ground; in the air only when forced."""
        if self._armed and self._in_flight and not force:
            return Result.FAILED
        if self._armed:
            self._disarm()
        return Result.ACCEPTED

    def terminate(self) -> Result:
        """Stop the rotors until the next boot."""
        self._terminated = True
        if self._armed:
            self._say(Severity.CRITICAL, "Terminated: disarming")
            self._disarm()
        return Result.ACCEPTED

    def hear_ground_station(self, system_id: int) -> None:
        """Only the ground station of SYSID_MYGCS counts."""
        self._links.hear_ground(self._parameters, system_id, self._time_s)

    def set_mode(self, mode: Mode) -> Result:
        """Change the mode, unless its conditions are not met; the reason is a status text."""
        mode = EQUIVALENTS.get(mode, mode)
        reason = self._reason_not_to_enter(mode)
        if reason is not None:
            self._say(Severity.WARNING, f"Mode change to {MODE_NAMES.get(mode, mode.name)} failed: {reason}")
            return Result.FAILED
        self.failsafe = False
        if mode is not self._mode:
            self._enter(mode)
        return Result.ACCEPTED

    def takeoff(self, altitude_m: float | None = None) -> Result:
        """In GUIDED and armed on the ground: climb to `altitude_m` (m) above home, and stay in GUIDED."""
        if (
            self._mode is not Mode.OFFBOARD
            or not self._armed
            or self._in_flight
            or altitude_m is None
            or not altitude_m > float(self.plans.home[2] - self._estimator.position[2])
        ):
            return Result.FAILED
        self._setpoint_at_s = None
        self._lift_off(float(self.plans.home[2]) - altitude_m)
        return Result.ACCEPTED

    def start_mission(self, first: int | None = None) -> Result:
        """AUTO, and off the ground if armed there; ArduPilot begins nowhere but where the mission is."""
        if first:
            return Result.DENIED
        result = self.set_mode(Mode.MISSION)
        self._navigator.may_lift_off = result is Result.ACCEPTED
        return result

    def change_speed(self, speed_m_s: float) -> Result:
        """Keep to this ground speed until the mode changes; WPNAV_SPEED for 0 and below."""
        self._loops = with_speed(self._loops, self._parameters, speed_m_s)
        return Result.ACCEPTED

    def enable_fence(self, *, enabled: bool) -> Result:
        """Mind the fence, or no longer."""
        self.set_parameter("FENCE_ENABLE", int(enabled))
        return Result.ACCEPTED

    def reposition(self, position: Vec3, yaw: float) -> Result:
        """GUIDED to another place, NED (m, rad); NaN keeps what is."""
        if self._reason_not_to_enter(Mode.OFFBOARD) is not None:
            return Result.DENIED
        self.failsafe = False
        if self._mode is not Mode.OFFBOARD:
            self._enter(Mode.OFFBOARD)
        self._interrupt_takeoff()
        self._setpoint_at_s = None
        here = self._loops.path.position
        self._guidance.fly_over([np.where(np.isfinite(position), position, here)], yaw)
        return Result.ACCEPTED

    def offboard_setpoint(self, setpoint: Setpoint) -> None:
        """A setpoint arrived now; GUIDED follows it at once, other modes do not look at it."""
        if self._mode is not Mode.OFFBOARD:
            return
        self._interrupt_takeoff()
        self._setpoint_at_s = self._time_s
        if self._guidance.follow(setpoint) and self._in_flight:
            begin_control(self._loops, self._estimator)

    # What it does by itself

    def begin_in_flight(self) -> None:
        """Fly already, armed, in GUIDED; the estimate says where."""
        self._armed = True
        self._mode = Mode.OFFBOARD
        self._takeoff.enter(Phase.FLIGHT)
        self._navigator.begin_flight()
        begin_hovering(self._loops, self._estimator)
        self._guidance.stop()

    def fly_tick(self, plant: Plant, first_step: int, noise: TickNoise) -> None:
        """Modes and failsafes, then the fast loop with the plant, for one tick."""
        self._update((first_step + STEPS_PER_TICK) / STEPS_PER_S)
        fly_tick(
            plant,
            self._estimator,
            self._loops,
            self._guidance.target,
            self._armed,
            self._takeoff.open_throttle,
            self._navigator.lands,
            first_step,
            noise,
        )

    def _update(self, until_s: float) -> None:
        jump = self._new_jump()
        if jump is not None:  # the path jumps along, so that the vehicle does not
            self._loops.path.position[:] += jump[0]
            self._loops.path.velocity[:] += jump[1]
        if self._armed:
            self._watch_position()
            self._watch_battery()
            self._watch_links()
            self._watch_ground()
            self._watch_fence()
            self._navigator.update(
                self._mode, self._time_s, landed=not self._in_flight, position_ok=self.position_ok
            )
            if self._in_flight:
                self._fly()
        self._time_s = until_s

    def _watch_position(self) -> None:
        """Land where it is lost, which is FS_EKF_ACTION's default."""
        if self._in_flight and not self.position_ok and self._mode not in (Mode.LAND, Mode.STABILIZE):
            self._say(Severity.CRITICAL, "EKF variance")
            self._fail_into(Mode.LAND)
            self._say(Severity.CRITICAL, "EKF Failsafe: changed to LAND Mode")

    def _watch_ground(self) -> None:
        """Leaving the ground, landing, and what follows from either."""
        before = self._takeoff.phase
        self._takeoff.update(float(self._loops.throttle[0]), self._known_velocity, TICK_S)
        if before is Phase.LIFTING and self._in_flight and self._climbs_to is not None:
            self._guidance.take_off(self._climbs_to)
        if self._takeoff.phase is not Phase.GROUND:
            return
        has_landed = before is Phase.FLIGHT and self._navigator.lands
        if has_landed or 0.0 < self._parameters.DISARM_DELAY <= self._takeoff.elapsed_s:
            self._disarm()

    def _fly(self) -> None:
        if self._mode is Mode.OFFBOARD:
            self._watch_setpoints()
        elif self._mode is Mode.HOLD:
            self._follow_sticks()
        self._watch_climb()
        if self._parameters.MOT_HOVER_LEARN:
            learn_while_hovering(self._loops, self._estimator)

    def _follow_sticks(self) -> None:
        """In LOITER sticks move the vehicle, and let go leave it where it comes to rest."""
        piloted = self._pilot.flies(self._time_s)
        if piloted:
            self._guidance.follow_sticks(self._pilot.sticks, yaw_of(self._estimator.attitude))
        elif self._was_piloted:
            self._guidance.stop()
        self._was_piloted = piloted

    def _watch_fence(self) -> None:
        """Beyond the fence do what FENCE_ACTION says; on the ground, disarm."""
        mode = self._navigator.broken_fence(self._time_s)
        if mode is None:
            return
        if not self._in_flight:
            self._disarm()
        elif self._mode is not Mode.LAND:
            self._fail_into(mode)

    def _lift_off(self, down: float) -> None:
        self._takeoff.enter(Phase.LIFTING)
        self._climbs_to = down

    def _watch_setpoints(self) -> None:
        at_s = self._setpoint_at_s
        if at_s is not None and self._time_s - at_s > self._parameters.GUID_TIMEOUT:
            self._setpoint_at_s = None
            self._guidance.lose_setpoints()

    def _watch_climb(self) -> None:
        if self._climbs_to is not None and self._estimator.position[2] < self._climbs_to + 0.1:
            self._climbs_to = None

    def _interrupt_takeoff(self) -> None:
        """Another target ends a takeoff; on the ground that leaves the vehicle there, as ArduPilot does."""
        self._climbs_to = None
        if self._takeoff.phase is Phase.LIFTING:
            self._takeoff.enter(Phase.GROUND)

    def _disarm(self) -> None:
        self._armed = False
        self._takeoff.enter(Phase.GROUND)
        self._climbs_to = None
        self._navigator.end_flight()
        self._say(Severity.INFO, "Disarming motors")

    def _watch_battery(self) -> None:
        """Warn when the voltage stays low, and land or return if BATT_FS_LOW_ACT says so."""
        if not self._low_battery.begins(self._parameters, float(self._pack.state[1])):
            return
        self._say(Severity.WARNING, f"Battery 1 is low {self._pack.state[1]:.2f}V")
        action = self._low_battery.action(self._parameters)
        if action is not None and self._in_flight and self._mode is not Mode.LAND:
            self._fail_into(action)
            self._say(Severity.CRITICAL, f"Battery Failsafe, mode {MODE_NAMES[action]}")

    def _watch_links(self) -> None:
        for link, action in self._links.lost(self._parameters, self._mode, self._pilot, self._time_s):
            self._say(Severity.WARNING, f"{link} Failsafe")
            if not self._in_flight:
                self._disarm()
            elif action is not self._mode:
                self._fail_into(action)

    def _count_items(self, kind: PlanKind, count: int) -> None:
        self._parameters = self._parameters.changed(_TOTALS[kind], count)

    def _fail_into(self, mode: Mode) -> None:
        self._enter(mode)
        self.failsafe = True

    def _enter(self, mode: Mode) -> None:
        self._mode = mode
        self._interrupt_takeoff()
        self._setpoint_at_s = None
        if self._in_flight:
            begin_control(self._loops, self._estimator)
            self._guidance.stop()
        self._navigator.enter(mode)

    @property
    def _in_flight(self) -> bool:
        return self._takeoff.phase is Phase.FLIGHT

    def _reason_not_to_enter(self, mode: Mode) -> str | None:
        return reason_not_to_enter(
            mode, self.plans.mission, self._armed, in_flight=self._in_flight, position_ok=self.position_ok
        )

    def _reason_not_to_arm(self) -> str | None:
        if self._terminated:
            return "Terminated"
        auto_arms = self._mode is Mode.MISSION and self._parameters.AUTO_OPTIONS & 1
        if self._mode not in _MODES_TO_ARM_IN and not auto_arms:
            return f"{MODE_NAMES[self._mode]} mode not armable"
        return self._failed_check() if self._parameters.ARMING_CHECK else None

    def _failed_check(self) -> str | None:
        if not self.position_ok:
            return "Need Position Estimate"
        if self._low_battery.forbids_arming(self._parameters, float(self._pack.state[1])):
            return "Battery failsafe"
        return None

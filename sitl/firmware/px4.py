"""A simulated PX4: modes, arming, failsafes, and the controllers behind them.

As https://docs.px4.io/main/en/flight_modes_mc/ and https://docs.px4.io/main/en/config/safety.html say.
"""

import numpy as np

from sitl.arrays import Vec3
from sitl.battery import Pack
from sitl.estimator import STEPS_PER_S, Estimator
from sitl.firmware import px4_checks as checks
from sitl.firmware.commander import Commander
from sitl.firmware.interface import AttitudeTarget, Estimate, Landed, Mode, Result, Setpoint, Severity
from sitl.firmware.px4_control import Control
from sitl.firmware.px4_failsafes import OFFBOARD_LOST, Action, BatteryWatch, Stop
from sitl.firmware.px4_guidance import Guidance
from sitl.firmware.px4_links import Links, may_be_piloted, may_override
from sitl.firmware.px4_navigator import Navigator
from sitl.firmware.px4_offboard import Offboard
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.firmware.px4_takeoff import AutoDisarm, LandDetector, TakeoffPhase
from sitl.firmware.px4_tuning import tuned_parameters
from sitl.plant import STEPS_PER_TICK, TICK_S, Plant, TickNoise
from sitl.vehicle import Vehicle


class Px4(Commander[Px4Parameters]):
    """Implements `interface.Firmware`."""

    dead_reckons_s = 5.0
    """EKF2_NOAID_TOUT."""
    _guidance: Guidance

    def __init__(self, vehicle: Vehicle, estimator: Estimator, pack: Pack) -> None:
        super().__init__(tuned_parameters(vehicle), estimator, pack, Mode.HOLD)
        self._control = Control(vehicle, self._parameters, estimator)
        self._guidance = Guidance(self._parameters, estimator, self._control.setpoint, TICK_S)
        self._navigator = Navigator(self._parameters, estimator, self._guidance, self._say)
        self.plans, self._fence = self._navigator.plans, self._navigator.fence
        self._land_detector = LandDetector(self._parameters)
        self._auto_disarm = AutoDisarm()
        self._offboard = Offboard()
        self._offboard_interrupted = False
        self._links = Links()
        self._armed_s = 0.0
        self._link_failsafe = False
        self._battery_watch = BatteryWatch()
        self._intended_mode = self._mode

    # What it reports

    @property
    def estimate(self) -> Estimate:
        """A copy of the estimate of this instant."""
        return self._control.estimate(self._time_s)

    @property
    def active_setpoint(self) -> Setpoint:
        """What the position controller follows now, in any mode."""
        return self._control.active_setpoint

    @property
    def attitude_target(self) -> AttitudeTarget:
        """What attitude and rate control follow now."""
        return self._control.attitude_target

    @property
    def landed(self) -> Landed:
        """As the land detector has it."""
        if self.on_ground:
            return Landed.ON_GROUND
        if self._mode is Mode.LAND:
            return Landed.LANDING
        if self._mode is Mode.TAKEOFF or self._control.takeoff.phase is TakeoffPhase.RAMPUP:
            return Landed.TAKING_OFF
        return Landed.IN_AIR

    @property
    def intended_mode(self) -> Mode:
        """The mode that was chosen last (nav_state_user_intention)."""
        return self._intended_mode

    @property
    def on_ground(self) -> bool:
        """Whether the land detector has the vehicle on the ground."""
        return self._land_detector.landed

    @property
    def failsafe(self) -> bool:
        """Whether a failsafe chose the present mode."""
        return self._offboard_interrupted or self._link_failsafe or self._battery_watch.level > 1

    # What it is asked

    def set_parameter(self, name: str, value: float) -> None:
        """Fly by another value from now on; see `interface.Autopilot`."""
        self._parameters = parameters = self._parameters.changed(name, value)
        self._control.use(parameters)
        self._guidance.use(parameters)
        self._navigator.use(parameters)
        self._land_detector.use(parameters)

    def arm(self, *, force: bool = False) -> Result:
        """Arm, unless a check refuses; the reason is a status text."""
        if self._armed:
            return Result.ACCEPTED
        reason = None if force else self._reason_not_to_arm()
        if reason is not None:
            self._say(Severity.CRITICAL, f"Arming denied: {reason}")
            return Result.TEMPORARILY_REJECTED
        self._armed = True
        self._armed_s = self._time_s
        self._auto_disarm.begin(self._time_s)
        self._navigator.begin_flight()
        self._say(Severity.INFO, "Armed by external command")
        return Result.ACCEPTED

    def check(self) -> Result:
        """What the checks find shows in SYS_STATUS."""
        return Result.ACCEPTED

    def disarm(self, *, force: bool = False) -> Result:
        """Disarm on the ground; in the air only when forced."""
        if self._armed and not self.on_ground and not force:
            self._say(Severity.CRITICAL, "Disarming denied: not landed")
            return Result.TEMPORARILY_REJECTED
        if self._armed:
            self._disarm("Disarmed by external command")
        return Result.ACCEPTED

    def terminate(self) -> Result:
        """Stop the rotors until the next boot."""
        if not self._armed:
            return Result.DENIED
        self._terminated = True
        self._disarm("Flight termination active")
        return Result.ACCEPTED

    def hear_ground_station(self, system_id: int) -> None:
        """Any ground station keeps the link alive."""
        self._links.hear_ground(self._time_s)

    def set_mode(self, mode: Mode) -> Result:
        """Change the mode, unless its conditions are not met; the reason is a status text."""
        if mode is Mode.TAKEOFF:
            return self.takeoff()
        reason = checks.reason_not_to_enter(mode, self._situation())
        if reason is not None:
            self._say(Severity.CRITICAL, f"Switching to mode {mode.name} denied: {reason}")
            return Result.TEMPORARILY_REJECTED
        self._choose(mode)
        if mode is not self._mode:
            self._enter(mode)
        return Result.ACCEPTED

    def start_mission(self, first: int | None = None) -> Result:
        """Mission mode from item `first` or where the mission is; arms, too."""
        mission = self.plans.mission
        if self._navigator.refusal is not None:
            self._say(Severity.CRITICAL, "Mission start denied! No valid mission")
            return Result.DENIED
        if first is not None and not 0 <= first < len(mission.plan):
            return Result.DENIED
        result = self.set_mode(Mode.MISSION)
        if result is not Result.ACCEPTED:
            return result
        if first is not None:
            mission.go_to(first)
        return self.arm()

    def change_speed(self, speed_m_s: float) -> Result:
        """Fly the present legs, and those of a mission, at this ground speed."""
        self._navigator.change_speed(speed_m_s)
        return Result.ACCEPTED

    def enable_fence(self, *, enabled: bool) -> Result:
        """PX4 minds its fence by GF_ACTION alone."""
        return Result.DENIED

    def takeoff(self, altitude_m: float | None = None) -> Result:
        """Takeoff mode to `altitude_m` (m) above the present height; MIS_TAKEOFF_ALT when None."""
        climb = self._parameters.MIS_TAKEOFF_ALT if altitude_m is None else altitude_m
        if altitude_m is None:
            self._say(Severity.INFO, f"Using default takeoff altitude: {climb:.1f} m")
        if climb < 0.0:
            self._say(Severity.CRITICAL, "Already higher than takeoff altitude")
            climb = 0.0
        self._choose(Mode.TAKEOFF)
        self._mode = Mode.TAKEOFF
        self._guidance.follow([self._estimator.position - np.array((0.0, 0.0, climb))])
        return Result.ACCEPTED

    def reposition(self, position: Vec3, yaw: float) -> Result:
        """Hold mode at another place, NED (m, rad); NaN keeps what is."""
        if self.on_ground:
            self._say(Severity.CRITICAL, "Reposition denied: not flying")
            return Result.TEMPORARILY_REJECTED
        self._choose(Mode.HOLD)
        self._enter(Mode.HOLD)
        target = np.where(np.isfinite(position), position, self._guidance.target)
        self._guidance.follow([target], yaw=yaw)
        return Result.ACCEPTED

    def offboard_setpoint(self, setpoint: Setpoint) -> None:
        """A setpoint arrived now; proof of life in any mode, unless all of it is switched off."""
        self._offboard.take(setpoint, self._time_s)

    # What it does by itself

    def begin_in_flight(self) -> None:
        """Fly already, armed, in OFFBOARD; the estimate says where."""
        self._armed = self._auto_disarm.has_flown = True
        self._mode = self._intended_mode = Mode.OFFBOARD
        self._control.begin_in_flight()
        self._land_detector.landed = False
        self._navigator.begin_flight()
        self.offboard_setpoint(Setpoint(position=self.plans.home.copy()))

    def fly_tick(self, plant: Plant, first_step: int, noise: TickNoise) -> None:
        """Commander, guidance and position control, then the inner loops with the plant, for one tick."""
        self._update()
        self._control.fly_tick(plant, first_step, noise, armed=self._armed, on_ground=self.on_ground)
        self._time_s = (first_step + STEPS_PER_TICK) / STEPS_PER_S

    def _update(self) -> None:
        jump = self._new_jump()
        if jump is not None:  # what was sent before jumps along
            self._control.jump(jump[1])
            self._offboard.jump(*jump)
        if self._armed:
            self._watch_position()
            self._watch_offboard()
            self._watch_pilot()
            self._watch_links()
            self._watch_battery()
            following = self._navigator.update(self._mode, self._time_s, landed=self.on_ground)
            if following is not None:
                self._do(following)
        p, takeoff = self._parameters, self._control.takeoff
        takeoff.update(armed=self._armed, landed=self.on_ground, wanted=self._wants_takeoff(), dt=TICK_S)
        climb = p.MPC_TKO_SPEED if self._mode is Mode.TAKEOFF else p.MPC_Z_VEL_MAX_UP
        max_up = takeoff.climb_limit(climb)
        self._write_setpoint(max_up)
        self._control.follow(max_up, armed=self._armed, on_ground=self.on_ground)
        self._watch_ground()

    def _write_setpoint(self, max_up: float) -> None:
        phase = self._control.takeoff.phase
        if max_up <= 0.0:
            self._guidance.restart()
        if phase < TakeoffPhase.RAMPUP:
            self._control.stay_down()
        elif self._mode is Mode.OFFBOARD:
            self._control.follow_setpoint(self._offboard.setpoint)
        elif not self.position_ok:
            self._control.descend_level()
        elif self._was_piloted:
            self._control.follow_sticks(self._pilot.sticks, max(max_up, 0.0))
        else:
            self._guidance.update(max(max_up, 0.0))

    def _wants_takeoff(self) -> bool:
        if not self._armed or not self.on_ground:
            return False
        if self._mode is Mode.OFFBOARD:
            return self._offboard_is_alive() and self._offboard.climbs_from(self._estimator.position[2])
        return self._guidance.climbs and (self._mode is Mode.TAKEOFF or self._is_amid_mission)

    @property
    def _is_amid_mission(self) -> bool:
        return self._mode is Mode.MISSION and not self.plans.mission.complete

    def _watch_ground(self) -> None:
        """Land detection, what follows from it, and the end of a takeoff."""
        was_on_ground, phase = self.on_ground, self._control.takeoff.phase
        self._land_detector.update(phase, self._known_velocity, self._control.thrust, TICK_S)
        if not self._armed:
            return
        if was_on_ground and not self.on_ground:
            self._auto_disarm.has_flown = True
            self._say(Severity.INFO, "Takeoff detected")
        elif self.on_ground and not was_on_ground:
            self._auto_disarm.wait(self._time_s)
            self._say(Severity.INFO, "Landing detected")
        if self.on_ground:
            self._disarm_when_idle()
        elif self._mode is Mode.TAKEOFF and self._guidance.at_height:
            self._mode = self._intended_mode = Mode.HOLD

    def _disarm_when_idle(self) -> None:
        if self._control.takeoff.phase is TakeoffPhase.RAMPUP:
            self._auto_disarm.wait(self._time_s)
        elif self._auto_disarm.is_due(self._parameters, self._time_s, amid_mission=self._is_amid_mission):
            self._disarm(self._auto_disarm.text)

    def _disarm(self, text: str) -> None:
        self._armed = False
        self._offboard_interrupted = self._link_failsafe = False
        self._say(Severity.INFO, text)
        if self._mode not in checks.MODES_TO_ARM_IN or self._mode is Mode.TAKEOFF:
            self._intended_mode = Mode.HOLD
            self._enter(Mode.HOLD)

    def _watch_position(self) -> None:
        """Without a position, descend: PX4's mode for that tells itself as LAND."""
        if self.position_ok or self.on_ground or self._mode in checks.WITHOUT_POSITION:
            return
        self._offboard_interrupted = self._mode is Mode.OFFBOARD
        self._link_failsafe = True
        self._act(Mode.LAND, "position estimate lost")

    def _watch_offboard(self) -> None:
        """Loss of the setpoints, and their return while nobody has chosen another mode since."""
        alive = self._offboard_is_alive()
        if self._mode is Mode.OFFBOARD and not alive:
            self._offboard_interrupted = True
            self._act(OFFBOARD_LOST[self._parameters.COM_OBL_RC_ACT], "offboard setpoints lost")
        elif self._offboard_interrupted and alive:
            self._offboard_interrupted = False
            self._enter(Mode.OFFBOARD)
            self._say(Severity.INFO, "Offboard setpoints regained")

    def _watch_pilot(self) -> None:
        """Sticks that are moved take over, where COM_RC_OVERRIDE lets them; let go, they leave a hold."""
        p, time_s = self._parameters, self._time_s
        piloted = may_be_piloted(p) and self._pilot.flies(time_s)
        moved = piloted and self._pilot.sticks.largest > 0.01 * p.COM_RC_STICK_OV
        if moved and self._mode not in (Mode.POSCTL, *checks.PILOTED) and may_override(p, self._mode):
            self._choose(Mode.POSCTL)
            self._enter(Mode.POSCTL)
            self._say(Severity.INFO, "Pilot took over using sticks")
        elif self._was_piloted and not piloted:
            self._guidance.hold()
        self._was_piloted = piloted and self._mode in (Mode.POSCTL, *checks.PILOTED)

    def _watch_links(self) -> None:
        if self._mode is Mode.LAND or self.on_ground:
            return
        loss = self._links.update(self._parameters, self._mode, self._pilot, self._armed_s, self._time_s)
        if loss is not None:
            self._link_failsafe = True
            self._act(*loss)

    def _act(self, action: Action, reason: str) -> None:
        """Do what a failsafe asks for, and say why."""
        self._say(Severity.WARNING, f"Failsafe: {reason}, {action.name}")
        if action is not self._mode:
            self._do(action)

    def _do(self, action: Action) -> None:
        if action is Stop.TERMINATE:
            self.terminate()
        elif action is Stop.DISARM:
            self._disarm("Disarmed by failsafe")
        else:
            self._enter(action)

    def _choose(self, mode: Mode) -> None:
        """Somebody chooses a mode: no failsafe changes it back."""
        self._intended_mode = mode
        self._offboard_interrupted = self._link_failsafe = False
        self._links.dismiss()

    def _watch_battery(self) -> None:
        """Warn when low, and do what follows from less."""
        remaining = float(self._pack.state[0])
        if not self._battery_watch.falls(self._parameters, remaining):
            return
        action = self._battery_watch.action(self._parameters)
        if action is None or self._mode is Mode.LAND or self.on_ground:
            self._say(Severity.WARNING, f"Low battery: {remaining:.0%}")
            return
        self._offboard_interrupted = False
        self._act(action, f"battery at {remaining:.0%}")

    def _enter(self, mode: Mode) -> None:
        self._mode = mode
        self._navigator.enter(mode)

    def _offboard_is_alive(self) -> bool:
        age_s = self._offboard.age_s(self._time_s)
        return age_s < self._parameters.COM_OF_LOSS_T and self.position_ok

    def _situation(self) -> checks.Situation:
        p, time_s = self._parameters, self._time_s
        return checks.Situation(
            armed=self._armed,
            terminated=self._terminated,
            piloted=self._pilot.is_there(time_s),
            ground_missed=self._links.misses_ground(p, time_s),
            offboard_alive=self._offboard_is_alive(),
            position_ok=self.position_ok,
            battery_low=bool(self._pack.state[0] < p.BAT_LOW_THR),
            mission_refusal=self._navigator.refusal,
        )

    def _reason_not_to_arm(self) -> str | None:
        return checks.reason_not_to_arm(self._mode, self._situation())

"""Where ArduPilot's AUTO, RTL and LAND fly, and its fence.

`mode_auto.cpp`, `mode_rtl.cpp`, `fence.cpp` of ArduCopter; https://ardupilot.org/copter/docs/auto-mode.html.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from sitl.arrays import Vec3
from sitl.estimator import Estimator
from sitl.firmware.ardupilot_guidance import Guidance
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.ardupilot_path import Path
from sitl.firmware.ardupilot_return import fence_limits, return_height, return_place
from sitl.firmware.fence_watch import FenceWatch
from sitl.firmware.interface import Mode, Severity
from sitl.geodesy import ARDUPILOT_EARTH_M
from sitl.plan.items import LOOKS, Command, Item, PlanKind
from sitl.plan.mission import Flight, Leg, Mission, MissionRules, Situation
from sitl.plan.places import bearing, local_place, looked_at
from sitl.plan.plans import Plans
from sitl.quaternion import yaw_of

_RULES = MissionRules(
    first=1,
    waypoint_params=False,
    reports_every_item=False,
    climbs_first=False,
    earth_radius_m=ARDUPILOT_EARTH_M,
)
_BREACH_MODES = {1: Mode.RTL, 2: Mode.LAND, 3: Mode.RTL, 4: Mode.BRAKE, 5: Mode.LAND}
_BREACH_NAMES = {"altitude": "Altitude", "distance": "Circle", "boundary": "Polygon"}
_HEIGHT_REACHED_M = 0.5
_CURRENT_PLACE = 1.0
_CIRCLE_RADIUS_M = 10.0
_CIRCLE_RATE_RAD_S = math.radians(20.0)
"""CIRCLE_RADIUS and CIRCLE_RATE."""
_FACES_WAYPOINTS = (1, 2, 3)


class Navigator:
    """Tells guidance where to fly.

    Attributes:
        plans: mission, fence, rally points and home.
        lands: whether the vehicle descends to the ground now.
        may_lift_off: whether AUTO may leave the ground: asked for by MISSION_START.
    """

    def __init__(
        self,
        parameters: ArduPilotParameters,
        estimate: Estimator,
        path: Path,
        guidance: Guidance,
        *,
        lift_off: Callable[[float], None],
        set_speed: Callable[[float], object],
        enable_fence: Callable[[bool], object],
        count_items: Callable[[PlanKind, int], object],
        say: Callable[[Severity, str], None],
    ) -> None:
        self._parameters = parameters
        self._estimate = estimate
        self._path = path
        self._guidance = guidance
        self._lift_off = lift_off
        self._set_speed = set_speed
        self._enable_fence = enable_fence
        self._count_items = count_items
        self._say = say
        self._mission = Mission(_RULES, self._perform)
        self.plans = Plans(estimate.position.copy(), self._mission, self._plan_changed)
        self.fence = FenceWatch()
        self.lands = False
        self.may_lift_off = False
        self._minds_floor = False
        self._limits = fence_limits(parameters, self.plans[PlanKind.FENCE])
        self._leg: Leg | None = None
        self._over_home_s: float | None = None
        self._roi: Vec3 | None = None

    def use(self, parameters: ArduPilotParameters) -> None:
        """Go by these from now on."""
        self._parameters = parameters
        self._limits = fence_limits(parameters, self.plans[PlanKind.FENCE])

    def begin_flight(self) -> None:
        """Armed now: home is here."""
        self.plans.home = self._estimate.position.copy()

    def end_flight(self) -> None:
        """Disarmed: a mission begins anew next time."""
        self._mission.restart()
        self.lands = self.may_lift_off = self._minds_floor = False

    def enter(self, mode: Mode) -> None:
        """Fly as a mode begins; guidance has stopped."""
        self._mission.pause()
        self._leg = self._roi = None
        self.lands = mode is Mode.LAND
        self.may_lift_off = False
        self._set_speed(0.0)
        if mode is Mode.RTL:
            self._return()
        elif mode is Mode.MISSION and (self._mission.complete or self._parameters.MIS_RESTART):
            self._mission.restart()

    def update(self, mode: Mode, time_s: float, *, landed: bool, position_ok: bool) -> None:
        """Follow mission, return or descent."""
        if self.lands:
            if not landed:
                height = float(self.plans.home[2] - self._estimate.position[2])
                self._guidance.descend(height, level=not position_ok)
        elif mode is Mode.RTL and not landed:
            self._follow_return(time_s)
        elif mode is Mode.MISSION and (not landed or self.may_lift_off or self._parameters.AUTO_OPTIONS & 2):
            self._follow_mission(time_s, landed=landed)

    def broken_fence(self, time_s: float) -> Mode | None:
        """What a breach of the fence asks for now."""
        limits = self._limits
        if limits is not None and not self._floor_counts():
            limits = replace(limits, least_height=-math.inf)
        if not self.fence.update(limits, self._estimate.position, self.plans.home, time_s):
            return None
        self._say(Severity.WARNING, f"{_BREACH_NAMES[self.fence.status.breach]} fence breached")
        return _BREACH_MODES.get(self._parameters.FENCE_ACTION)

    def _floor_counts(self) -> bool:
        """From FENCE_MARGIN above it on, until the vehicle lands (`AC_Fence::auto_enable_fence_floor`)."""
        p = self._parameters
        height = float(self.plans.home[2] - self._estimate.position[2])
        was_passed = self._minds_floor or height >= p.FENCE_ALT_MIN + p.FENCE_MARGIN
        self._minds_floor = was_passed and not self.lands
        return self._minds_floor

    def _follow_mission(self, time_s: float, *, landed: bool) -> None:
        e = self._estimate
        now = Situation(
            time_s=time_s,
            position=e.position,
            yaw=yaw_of(e.attitude),
            home=self.plans.home,
            landed=landed,
            radius=0.01 * self._parameters.WPNAV_RADIUS,
            height=_HEIGHT_REACHED_M,
        )
        was_complete = self._mission.complete
        leg = self._mission.update(now)
        if leg is not None:
            self._leg = leg
            self._fly(leg, landed=landed)
        elif self._mission.complete:
            if not was_complete:
                self._leg = None
                self._guidance.stop()
            return
        if self._leg is not None and self._leg.flight is Flight.CIRCLE:
            self._circle(self._leg)
        elif self._leg is not None and self._leg.flight is Flight.LAND:
            self.lands = self._guidance.arrived
        elif self._leg is not None and self._leg.flight is Flight.RETURN:
            self._follow_return(time_s)
        if self._roi is not None and self._mission.looks:
            yaw = bearing(e.position, self._roi)
            if not math.isnan(yaw):
                self._guidance.turn(yaw)

    def _fly(self, leg: Leg, *, landed: bool) -> None:
        here = self._path.position
        match leg.flight:
            case Flight.CLIMB if landed:
                self._lift_off(float(leg.place[2]))
            case Flight.CLIMB:
                self._guidance.take_off(float(leg.place[2]))
            case Flight.GO:
                self._guidance.fly_over([leg.place], faces_path=self._faces_waypoints)
            case Flight.LAND:
                self._guidance.fly_over([np.array((leg.place[0], leg.place[1], here[2]))])
            case Flight.RETURN:
                self._return()
            case Flight.STAY:
                self._guidance.stop()
            case Flight.CIRCLE:
                pass

    @property
    def _faces_waypoints(self) -> bool:
        return self._parameters.WP_YAW_BEHAVIOR in _FACES_WAYPOINTS

    def _circle(self, leg: Leg) -> None:
        """First to the nearest point of the circle, then round it, clockwise for a positive radius."""
        radius = abs(leg.radius) or _CIRCLE_RADIUS_M
        away = self._path.position - leg.place
        bearing = math.atan2(away[1], away[0])
        outward = np.array((math.cos(bearing), math.sin(bearing), 0.0))
        edge = leg.place + radius * outward
        if float(np.linalg.norm(edge - self._path.position)) > 0.01 * self._parameters.WPNAV_RADIUS:
            self._guidance.fly_over([edge], faces_path=self._faces_waypoints)
            return
        fastest = math.sqrt(0.5 * 0.01 * self._parameters.WPNAV_ACCEL / radius)
        rate = math.copysign(min(_CIRCLE_RATE_RAD_S, fastest), leg.radius or 1.0)
        tangent = np.array((-outward[1], outward[0], 0.0))
        self._guidance.fly_along(edge, rate * radius * tangent, -(rate**2) * radius * outward)

    def _return(self) -> None:
        p, here = self._parameters, self._path.position
        place, home = return_place(p, self.plans, here), self.plans.home
        down = float(home[2]) - return_height(p, place, here, home)
        self._over_home_s = None
        if p.RTL_SPEED:
            self._set_speed(0.01 * p.RTL_SPEED)
        self._guidance.fly_over(
            [np.array((here[0], here[1], down)), np.array((place[0], place[1], down))],
            faces_path=p.WP_YAW_BEHAVIOR in (1, 3),
        )

    def _follow_return(self, time_s: float) -> None:
        """Over the legs, wait for RTL_LOIT_TIME above the place, then land or go down to RTL_ALT_FINAL."""
        p = self._parameters
        self._guidance.next_leg()
        if not self._guidance.arrived or self._over_home_s == math.inf:
            return
        if self._over_home_s is None:
            self._over_home_s = time_s
        elif time_s - self._over_home_s >= 1e-3 * p.RTL_LOIT_TIME:
            self._over_home_s = math.inf
            if p.RTL_ALT_FINAL:
                above = self._guidance.target.position.copy()
                above[2] = float(self.plans.home[2]) - 0.01 * p.RTL_ALT_FINAL
                self._guidance.fly_over([above])
            else:
                self.lands = True

    def _perform(self, item: Item) -> None:
        if item.command == Command.DO_CHANGE_SPEED:
            self._set_speed(item.param(2))
        elif item.command == Command.DO_FENCE_ENABLE:
            self._enable_fence(item.param(1) == 1.0)
        elif item.command in LOOKS:
            self._roi = looked_at(item, self.plans.home, ARDUPILOT_EARTH_M)
        elif item.command == Command.DO_SET_HOME:
            here = item.param(1) == _CURRENT_PLACE
            there = local_place(item, self.plans.home, ARDUPILOT_EARTH_M)
            self.plans.home = self._estimate.position.copy() if here else there

    def _plan_changed(self, kind: PlanKind) -> None:
        self._count_items(kind, len(self.plans[kind]))
        self._limits = fence_limits(self._parameters, self.plans[PlanKind.FENCE])

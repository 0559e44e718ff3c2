"""PX4's navigator: which way the AUTO modes fly, mission and fence included.

https://docs.px4.io/main/en/flight_modes_mc/mission.html, https://docs.px4.io/main/en/flight_modes_mc/return.html,
https://docs.px4.io/main/en/flying/geofence.html.
"""

import math
from collections.abc import Callable

import numpy as np

from sitl.arrays import Vec3
from sitl.estimator import Estimator
from sitl.firmware.fence_watch import FenceWatch
from sitl.firmware.interface import Mode, Severity
from sitl.firmware.px4_failsafes import BREACH_ACTIONS, Action
from sitl.firmware.px4_feasibility import fence_limits, reason_to_refuse
from sitl.firmware.px4_guidance import Guidance
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.firmware.px4_return import return_height, return_place
from sitl.plan.items import LOOKS, Command, Item, PlanKind
from sitl.plan.mission import Flight, Leg, Mission, MissionRules, Situation
from sitl.plan.places import bearing, local_place, looked_at
from sitl.plan.plans import Plans
from sitl.quaternion import yaw_of

_RULES = MissionRules(first=0, waypoint_params=True, reports_every_item=True, climbs_first=True)
_CURRENT_PLACE = 1.0
_HOME_MODES = (1, 2)
_AWAY_FROM_HOME = 2
"""MPC_YAW_MODE."""

Say = Callable[[Severity, str], None]


class Navigator:
    """Tells guidance where to fly, and the commander which mode should follow.

    Attributes:
        plans: mission, fence, rally points and home.
        refusal: why the mission cannot be flown; None when it can.
    """

    def __init__(self, parameters: Px4Parameters, estimate: Estimator, guidance: Guidance, say: Say) -> None:
        self._parameters = parameters
        self._estimate = estimate
        self._guidance = guidance
        self._say = say
        self._mission = Mission(_RULES, self._perform)
        self.plans = Plans(estimate.position.copy(), self._mission, self._plan_changed)
        self.fence = FenceWatch()
        self.landed = True
        self._limits = fence_limits(parameters, self.plans[PlanKind.FENCE])
        self.refusal: str | None = "no valid mission available"
        self._next: Mode | None = None
        self._roi: Vec3 | None = None
        self._waits_from_s: float | None = None

    def use(self, parameters: Px4Parameters) -> None:
        """Go by these from now on."""
        self._parameters = parameters
        self._limits = fence_limits(parameters, self.plans[PlanKind.FENCE])

    def begin_flight(self) -> None:
        """Armed now: home is here, and a mission that was flown begins anew."""
        self.plans.home = self._estimate.position.copy()
        if self._mission.complete:
            self._mission.restart()

    def enter(self, mode: Mode) -> None:
        """Fly as a mode begins."""
        self._mission.pause()
        self._next = self._roi = None
        if mode is not Mode.MISSION:
            self._guidance.speed = None
        if mode is Mode.LAND:
            self._guidance.land()
        elif mode is Mode.RTL:
            self._return()
        else:
            self._guidance.hold()

    def change_speed(self, speed_m_s: float) -> None:
        """Ground speed (m/s) of the present mode and of the mission; below 0 the usual one."""
        self._guidance.speed = speed_m_s if speed_m_s > 0.0 else None

    def update(self, mode: Mode, time_s: float, *, landed: bool) -> Action | None:
        """Follow mission or return, and mind the fence; what should come next, if anything else should."""
        self.landed = landed
        breached = self._broken_fence(time_s)
        if breached is not None and not landed and mode is not Mode.LAND:
            return breached
        if mode is Mode.MISSION:
            return self._follow_mission(time_s)
        if mode is Mode.RTL:
            self._wait_over_landing(time_s)
        return None

    def _broken_fence(self, time_s: float) -> Action | None:
        """What a breach of the fence asks for now; nothing where it is a warning only."""
        p = self._parameters
        if not self.fence.update(self._limits, self._estimate.position, self.plans.home, time_s):
            return None
        action = BREACH_ACTIONS.get(p.GF_ACTION)
        text = f"Geofence violation: {self.fence.status.breach}"
        self._say(Severity.WARNING, text if action is None else f"{text}, {action.name}")
        return action

    def _follow_mission(self, time_s: float) -> Mode | None:
        p, e = self._parameters, self._estimate
        now = Situation(
            time_s=time_s,
            position=e.position,
            yaw=yaw_of(e.attitude),
            home=self.plans.home,
            landed=self.landed,
            radius=p.NAV_ACC_RAD,
            height=p.NAV_MC_ALT_RAD,
        )
        was_complete = self._mission.complete
        leg = self._mission.update(now)
        if leg is not None:
            self._fly(leg)
        if self._mission.looks:
            self._look()
        if self._mission.complete and not was_complete:
            self._say(Severity.INFO, f"Mission finished, {'landed' if self.landed else 'loitering'}")
        return self._next

    def _look(self) -> None:
        """Turn to the region of interest, or as MPC_YAW_MODE has it."""
        mode, here = self._parameters.MPC_YAW_MODE, self._estimate.position
        place = self.plans.home if self._roi is None and mode in _HOME_MODES else self._roi
        yaw = math.nan if place is None else bearing(here, place)
        if not math.isnan(yaw):
            self._guidance.turn(yaw + math.pi if self._roi is None and mode == _AWAY_FROM_HOME else yaw)

    def _fly(self, leg: Leg) -> None:
        here = self._estimate.position
        match leg.flight:
            case Flight.CLIMB:
                least = float(self.plans.home[2]) - self._parameters.MIS_TAKEOFF_ALT
                down = min(float(leg.place[2]), least) if self.landed else float(leg.place[2])
                self._guidance.follow([np.array((here[0], here[1], down))], yaw=leg.yaw)
            case Flight.LAND:
                self._guidance.land_at(leg.place)
            case Flight.RETURN:
                self._next = Mode.RTL
            case Flight.STAY:
                self._guidance.hold()
            case _:
                self._guidance.turn_to(leg.place, yaw=leg.yaw)

    def _perform(self, item: Item) -> None:
        if item.command == Command.DO_CHANGE_SPEED:
            self.change_speed(item.param(2, -1.0))
        elif item.command in LOOKS:
            self._roi = looked_at(item, self.plans.home)
        elif item.command == Command.DO_SET_HOME:
            here = item.param(1) == _CURRENT_PLACE
            self.plans.home = self._estimate.position.copy() if here else local_place(item, self.plans.home)

    def _return(self) -> None:
        p, here = self._parameters, self._estimate.position
        place = return_place(p, self.plans, here)
        down = float(place[2]) - return_height(p, place, here)
        descended = max(down, float(place[2]) - p.RTL_DESCEND_ALT)
        self._waits_from_s = None
        self._guidance.follow(
            [
                np.array((here[0], here[1], down)),
                np.array((place[0], place[1], down)),
                np.array((place[0], place[1], descended)),
            ],
            lands=p.RTL_LAND_DELAY == 0.0,
        )

    def _wait_over_landing(self, time_s: float) -> None:
        delay_s = self._parameters.RTL_LAND_DELAY
        if delay_s <= 0.0 or not self._guidance.at_end:
            return
        if self._waits_from_s is None:
            self._waits_from_s = time_s
        elif time_s - self._waits_from_s >= delay_s:
            self._waits_from_s = math.inf
            self._guidance.land()

    def _plan_changed(self, kind: PlanKind) -> None:
        self._limits = fence_limits(self._parameters, self.plans[PlanKind.FENCE])
        mission = self.plans[PlanKind.MISSION]
        if not mission.items:
            self.refusal = "no valid mission available"
            return
        home = self.plans.home
        self.refusal = reason_to_refuse(mission, self._limits, self._parameters, home, landed=self.landed)
        if self.refusal and kind is not PlanKind.RALLY:
            self._say(Severity.CRITICAL, f"Mission rejected: {self.refusal}")

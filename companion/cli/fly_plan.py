"""`companion fly survey.plan`: a mission plan, tracked as a trajectory instead of flown by the autopilot."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from companion.flight.fence import Fence
from companion.flight.flight import After, FlightPlan
from companion.flight.guard import GuardLimits, require_flyable
from companion.flight.takeoff import Announce
from companion.link.connection import Connection
from companion.link.telemetry import Telemetry
from companion.mission.boundaries import areas_of, require_inside_areas, require_inside_box, require_near
from companion.mission.items import Plan
from companion.mission.path import TrackedPath, tracked_path
from companion.mission.site import Site, planned_site, vehicle_site
from companion.mission.vehicle_fence import vehicle_fence
from companion.trajectory import Limits, Trajectory
from companion.trajectory.summary import summarise
from companion.trajectory.waypoints import trajectory_through

_SUFFIXES = (".plan", ".waypoints", ".wpl")


def is_plan(name: str) -> bool:
    """Whether a file of this name is a mission plan."""
    return Path(name).suffix.lower() in _SUFFIXES


@dataclass(frozen=True, eq=False)
class Planned:
    """A plan to be tracked.

    Attributes:
        name: of the plan.
        plan: what it holds.
        make: `FlightPlan`, but for its trajectory, the guard's limits and what the plan says itself.
        guard: how far it may lead; None for the usual limits, with a box of its own size.
        after: how the vehicle is handed back; None leaves it to the plan.
        resume: whether to begin where a takeoff leads although the vehicle is in the air.
    """

    name: str
    plan: Plan
    make: Callable[..., FlightPlan]
    guard: GuardLimits | None
    after: After | None
    resume: bool

    def preview(self, limits: Limits) -> list[str]:
        """What would be flown from the plan's own home, in lines; InputError where it cannot be."""
        return self._laid(planned_site(self.plan), limits).lines(limits)

    async def lay(
        self, connection: Connection, telemetry: Telemetry, limits: Limits, announce: Announce
    ) -> FlightPlan:
        """The flight from where the vehicle is; InputError where a fence or a limit forbids it."""
        site = await vehicle_site(connection, telemetry)
        laid = self._laid(site, limits)
        own = await vehicle_fence(connection, telemetry, announce)
        own.bounds.require_inside(laid.trajectory)
        require_inside_areas(laid.path, laid.trajectory, own, "vehicle")
        for line in laid.lines(limits):
            announce(line)
        return self.make(
            laid.trajectory,
            limits=laid.guard,
            vehicle_fence=own,
            takeoff_altitude_m=laid.path.takeoff_altitude_m,
            after=self.after or After[laid.path.ending.name],
        )

    def _laid(self, site: Site, limits: Limits) -> "_Laid":
        """The plan laid out at `site`; InputError where a fence or a limit forbids it."""
        path = tracked_path(self.plan, replace(site, airborne=None) if self.resume else site)
        here = site.start(path.takeoff_altitude_m)
        positions = np.array([here, *(waypoint.position for waypoint in path.waypoints)])
        guard = self.guard or GuardLimits(fence=Fence.around(positions))
        require_near(path, site.start(0.0), guard.max_distance_m)
        require_inside_box(path, *guard.fence.corners())
        trajectory = trajectory_through(self.name, path.waypoints, limits)
        require_flyable(trajectory, guard)
        require_inside_areas(path, trajectory, areas_of(self.plan.fence, site), "plan")
        return _Laid(path, trajectory, guard)


@dataclass(frozen=True, eq=False)
class _Laid:
    """A plan where it is to be flown."""

    path: TrackedPath
    trajectory: Trajectory
    guard: GuardLimits

    def lines(self, limits: Limits) -> list[str]:
        """What will be flown, in lines."""
        return [
            *summarise(self.trajectory, limits).lines(),
            f"no setpoint leaves {self.guard.fence}",
            *self.path.remarks,
        ]

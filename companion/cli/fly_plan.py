"""`companion fly survey.plan`: a mission plan, tracked as a trajectory instead of flown by the autopilot."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from companion.errors import NoReplyError
from companion.flight.flight import After, FlightPlan
from companion.flight.guard import GuardLimits
from companion.flight.takeoff import Announce
from companion.link.connection import Connection
from companion.link.telemetry import Telemetry
from companion.mission.boundaries import require_inside_box, require_inside_fence, require_near
from companion.mission.items import Plan
from companion.mission.path import TrackedPath, tracked_path
from companion.mission.site import Site, planned_site, vehicle_site
from companion.mission.transfer import download_fence
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
        make: `FlightPlan`, but for its trajectory and what the plan says itself.
        guard: how far it may lead.
        after: how the vehicle is handed back; None leaves it to the plan.
        resume: whether to begin where a takeoff leads although the vehicle is in the air.
    """

    name: str
    plan: Plan
    make: Callable[..., FlightPlan]
    guard: GuardLimits
    after: After | None
    resume: bool

    def preview(self, limits: Limits) -> list[str]:
        """What would be flown from the plan's own home, in lines; InputError where it cannot be."""
        path, trajectory = self._laid(planned_site(self.plan), limits)
        return [*summarise(trajectory, limits).lines(), *path.remarks]

    async def lay(
        self, connection: Connection, telemetry: Telemetry, limits: Limits, announce: Announce
    ) -> FlightPlan:
        """The flight from where the vehicle is; InputError where a fence or a limit forbids it."""
        site = await vehicle_site(connection, telemetry)
        if self.resume:
            site = replace(site, airborne=None)
        path, trajectory = self._laid(site, limits)
        try:
            fence = await download_fence(connection)
        except NoReplyError:
            announce("the vehicle tells no fence: only the plan's and the guard's are kept to")
        else:
            require_inside_fence(path, trajectory, fence, site, "vehicle")
        for line in (*summarise(trajectory, limits).lines(), *path.remarks):
            announce(line)
        after = self.after or After[path.ending.name]
        return self.make(trajectory, takeoff_altitude_m=path.takeoff_altitude_m, after=after)

    def _laid(self, site: Site, limits: Limits) -> tuple[TrackedPath, Trajectory]:
        """The plan laid out at `site`; InputError where a fence or a limit forbids it."""
        path = tracked_path(self.plan, site)
        require_near(path, site.start(0.0), self.guard.max_distance_m)
        require_inside_box(path, *self.guard.fence.corners())
        trajectory = trajectory_through(self.name, path.waypoints, limits)
        require_inside_fence(path, trajectory, self.plan.fence, site, "plan")
        return path, trajectory

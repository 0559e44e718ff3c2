"""What ArduPilot's modes want of the position controller: a target for each of them."""

import math

import numpy as np

from sitl.arrays import Vec3
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.ardupilot_path import Follow, Path, target
from sitl.firmware.ardupilot_shaping import sqrt_controller
from sitl.firmware.interface import Setpoint
from sitl.firmware.pilot import Sticks

_ARRIVED_M = 0.5
_LOWEST_M = 1.0
"""Height up to which a descent slows down to LAND_SPEED at the latest."""

_FOLLOW = {
    (True, True, False): Follow.TRAJECTORY,
    (True, True, True): Follow.TRAJECTORY,
    (True, False, False): Follow.POSITION,
    (False, True, False): Follow.VELOCITY,
    (False, True, True): Follow.VELOCITY,
    (False, False, True): Follow.ACCELERATION,
}
"""What GUIDED follows when a setpoint has position, velocity, acceleration; nothing else is flown."""


class Guidance:
    """Writes the target for whatever it was last told to do.

    Attributes:
        target: for the position controller.
    """

    def __init__(self, parameters: ArduPilotParameters, path: Path) -> None:
        self.use(parameters)
        self._path = path
        self._legs: list[Vec3] = []
        self.target = target()
        self.stop()

    def use(self, parameters: ArduPilotParameters) -> None:
        """Go by these from now on."""
        self._parameters = parameters

    @property
    def setpoint(self) -> Setpoint:
        """The target, its channels that do not count switched off."""
        goal = self.target
        horizontal, vertical = Follow(goal.follow[0]), Follow(goal.follow[1])
        axes = np.array((horizontal, horizontal, vertical))
        moving = (axes == Follow.TRAJECTORY) | (axes == Follow.VELOCITY)
        return Setpoint(
            position=np.where(axes <= Follow.TRAJECTORY, goal.position, math.nan),
            velocity=np.where(moving, goal.velocity, math.nan),
            acceleration=np.where(moving | (axes == Follow.ACCELERATION), goal.acceleration, math.nan),
            yaw=float(goal.heading[0]),
            yaw_rate=float(goal.heading[1]),
        )

    @property
    def arrived(self) -> bool:
        """Whether the path is at the end of the last leg."""
        goal = self.target.position
        return len(self._legs) <= 1 and float(np.linalg.norm(self._path.position - goal)) < _ARRIVED_M

    def stop(self) -> None:
        """Brake and stay where that ends, with the heading of now."""
        self._aim(Follow.VELOCITY, Follow.VELOCITY)

    def follow(self, setpoint: Setpoint) -> bool:
        """Fly by a setpoint, or stop for one that GUIDED does not know; whether it is of another kind now.

        A channel counts only with all its axes.
        """
        channels = (setpoint.position, setpoint.velocity, setpoint.acceleration)
        given = [bool(np.isfinite(channel).all()) for channel in channels]
        kind = _FOLLOW.get((given[0], given[1], given[2]))
        if kind is None:
            self.stop()
            return True
        before = tuple(self.target.follow)
        position, velocity, acceleration = (
            channel if used else np.zeros(3) for channel, used in zip(channels, given, strict=True)
        )
        self._aim(kind, kind, position, velocity, acceleration)
        self.target.heading[:] = setpoint.yaw, setpoint.yaw_rate
        if math.isfinite(setpoint.yaw) and not math.isfinite(setpoint.yaw_rate):
            self.target.heading[1] = 0.0
        return before != (kind, kind)

    def follow_sticks(self, sticks: Sticks, heading: float) -> None:
        """Fly as the pilot's sticks ask for; `heading` of the vehicle (rad)."""
        p = self._parameters
        speeds = 0.01 * p.LOIT_SPEED, 0.01 * p.WPNAV_SPEED_UP, 0.01 * p.WPNAV_SPEED_DN
        yaw_rate = math.radians(p.PILOT_Y_RATE) * sticks.yaw
        self.follow(Setpoint(velocity=sticks.velocity(heading, *speeds), yaw_rate=yaw_rate))

    def lose_setpoints(self) -> None:
        """What GUIDED makes of silence: a moving target stops, a place stays a target."""
        goal = self.target
        if goal.follow[0] == Follow.ACCELERATION:
            goal.follow[:] = Follow.VELOCITY
        goal.velocity[:] = goal.acceleration[:] = 0.0
        goal.heading[1] = 0.0

    def take_off(self, down: float) -> None:
        """Straight up to `down` (m)."""
        self._aim(Follow.VELOCITY, Follow.TRAJECTORY, np.array((0.0, 0.0, down)))

    def fly_over(self, legs: list[Vec3], yaw: float = math.nan, *, faces_path: bool = False) -> None:
        """To the places in turn, to a stop at each; NaN yaw keeps the heading, or looks along the path."""
        self._legs = legs
        self._aim(Follow.POSITION, Follow.POSITION, legs[0])
        if faces_path:
            self.target.heading[:] = math.nan
        elif not math.isnan(yaw):
            self.target.heading[:] = yaw, 0.0

    def fly_along(self, position: Vec3, velocity: Vec3, acceleration: Vec3) -> None:
        """On a path that is given point by point, looking along it."""
        self._aim(Follow.TRAJECTORY, Follow.TRAJECTORY, position, velocity, acceleration)
        self.target.heading[:] = math.nan

    def turn(self, yaw: float) -> None:
        """Turn to a heading (rad); the target stays."""
        self.target.heading[:] = yaw, 0.0

    def next_leg(self) -> None:
        """Turn to the next place once the path is at one."""
        if len(self._legs) > 1 and float(np.linalg.norm(self._path.position - self._legs[0])) < _ARRIVED_M:
            del self._legs[0]
            self.target.position[:] = self._legs[0]

    def descend(self, height: float, *, level: bool = False) -> None:
        """Straight down, `height` (m) above home: fast, but slow below LAND_ALT_LOW.

        Without a position as `level` as the wind lets it, for nobody moves the sticks (`mode_land.cpp`).
        """
        p = self._parameters
        slow, fast = 0.01 * p.LAND_SPEED, 0.01 * (p.LAND_SPEED_HIGH or p.WPNAV_SPEED_DN)
        left = height - max(0.01 * p.LAND_ALT_LOW, _LOWEST_M)
        speed = sqrt_controller(left, 1.0, 0.01 * p.WPNAV_ACCEL_Z, 0.0)
        horizontal = Follow.LEVEL if level else Follow.VELOCITY
        if self.target.follow[0] != horizontal or self.target.velocity[:2].any():
            self._aim(horizontal, Follow.VELOCITY)
        self.target.velocity[2] = min(max(speed, slow), max(fast, slow))

    def _aim(
        self,
        horizontal: Follow,
        vertical: Follow,
        position: Vec3 | None = None,
        velocity: Vec3 | None = None,
        acceleration: Vec3 | None = None,
    ) -> None:
        goal = self.target
        goal.follow[:] = horizontal, vertical
        goal.position[:] = 0.0 if position is None else position
        goal.velocity[:] = 0.0 if velocity is None else velocity
        goal.acceleration[:] = 0.0 if acceleration is None else acceleration
        goal.heading[:] = math.nan, 0.0

"""Where the AUTO modes go, and POSCTL without a pilot: a smooth path over targets, then hold or land."""

import math

import numpy as np

from sitl.arrays import Vec3
from sitl.estimator import Estimator
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.firmware.px4_position import PositionSetpoint
from sitl.firmware.smooth_path import PathLimits, approach, begin, braking_distance, path_at_rest
from sitl.quaternion import yaw_of

_ARRIVED_M = 0.2
_FAR_ENOUGH_TO_LOOK_M = 1.0
_YAW_SPEED_RAD_S = math.radians(45.0)
_SLOW_DESCENT_HEIGHT_M = 5.0
_FAST_DESCENT_HEIGHT_M = 10.0
"""MPC_LAND_ALT2 and MPC_LAND_ALT1: between them the descent slows from MPC_Z_VEL_MAX_DN to MPC_LAND_SPEED."""
_AHEAD_M = 5.0


class Guidance:
    """Writes position, velocity and acceleration setpoints for whatever it was last told to do.

    Attributes:
        speed: over ground (m/s); None for MPC_XY_CRUISE.
    """

    def __init__(
        self, parameters: Px4Parameters, estimate: Estimator, setpoint: PositionSetpoint, dt: float
    ) -> None:
        self._dt = dt
        self._estimate = estimate
        self._setpoint = setpoint
        self.use(parameters)
        self._path = path_at_rest(parameters.MPC_ACC_HOR, parameters.MPC_JERK_AUTO, dt)
        self._targets: list[Vec3] = []
        self._lands = False
        self._target_yaw = 0.0
        self._yaw = 0.0
        self.speed: float | None = None
        self.hold()

    def use(self, parameters: Px4Parameters) -> None:
        """Go by these from now on; the jerk limit counts from the next target."""
        self._parameters = parameters

    @property
    def target(self) -> Vec3:
        """Where the present leg ends, NED (m)."""
        return self._targets[0]

    @property
    def at_height(self) -> bool:
        """Whether the vehicle, by its estimate, is at the height where the present leg ends."""
        return abs(float(self._estimate.position[2] - self.target[2])) < _ARRIVED_M

    @property
    def climbs(self) -> bool:
        """Whether the present leg ends above the vehicle."""
        return float(self.target[2]) < float(self._estimate.position[2])

    @property
    def at_end(self) -> bool:
        """Whether the path is at the last target."""
        gap = float(np.linalg.norm(self._path.position - self.target))
        return len(self._targets) == 1 and gap < _ARRIVED_M

    def hold(self) -> None:
        """Brake and stay where that ends."""
        self.follow([self._braking_point()])

    def follow(self, targets: list[Vec3], *, yaw: float = math.nan, lands: bool = False) -> None:
        """Fly over `targets` in turn from here; `lands`: descend at the last. NaN yaw keeps the heading."""
        self.restart()
        self._targets = targets
        self._lands = lands
        self._yaw = yaw_of(self._estimate.attitude)
        self._target_yaw = self._yaw if math.isnan(yaw) else yaw

    def turn_to(self, target: Vec3, *, yaw: float) -> None:
        """Fly to another target without a stop; NaN yaw looks there."""
        self._targets = [target]
        self._lands = False
        north, east = target[0] - self._path.position[0], target[1] - self._path.position[1]
        if not math.isnan(yaw):
            self._target_yaw = yaw
        elif math.hypot(north, east) > _FAR_ENOUGH_TO_LOOK_M:
            self._target_yaw = math.atan2(east, north)

    def turn(self, yaw: float) -> None:
        """Turn to a heading (rad); the targets stay."""
        self._target_yaw = yaw

    def land_at(self, place: Vec3) -> None:
        """Fly over a place at the present height, and descend there."""
        here = self._path.position
        self._targets = [np.array((place[0], place[1], here[2])), place]
        self._lands = True

    def land(self) -> None:
        """Brake and descend where that ends."""
        self.follow([self._braking_point()], lands=True)

    def restart(self) -> None:
        """Let the path begin anew at the vehicle; targets stay."""
        p = self._parameters
        self._path = path_at_rest(p.MPC_ACC_HOR, p.MPC_JERK_AUTO, self._dt)
        begin(self._path, self._estimate.position, self._estimate.velocity, self._dt)

    def update(self, max_up: float) -> None:
        """Move the path on by one step, climbing at most at `max_up` (m/s), and write the setpoint."""
        p, dt = self._parameters, self._dt
        descends = self._lands and len(self._targets) == 1
        target = self.target
        if descends:
            target = np.array((target[0], target[1], self._path.position[2] + _AHEAD_M))
        down = self._descent_speed() if descends else p.MPC_Z_VEL_MAX_DN
        cruise = p.MPC_XY_CRUISE if self.speed is None else self.speed
        approach(self._path, target, PathLimits(cruise, max_up, down, p.MPC_ACC_HOR), dt)
        if len(self._targets) > 1 and float(np.linalg.norm(self._path.position - target)) < _ARRIVED_M:
            del self._targets[0]
        turn = math.remainder(self._target_yaw - self._yaw, 2.0 * math.pi)
        step = _YAW_SPEED_RAD_S * dt
        self._yaw += min(max(turn, -step), step)

        setpoint = self._setpoint
        setpoint.position[:] = self._path.position
        setpoint.velocity[:] = self._path.velocity
        setpoint.acceleration[:] = self._path.acceleration
        if descends:  # the ground, not the path, decides where the descent ends
            setpoint.position[2] = math.nan
        setpoint.heading[0] = self._yaw
        setpoint.heading[1] = 0.0

    def _descent_speed(self) -> float:
        p = self._parameters
        height = -self._estimate.position[2]
        share = (height - _SLOW_DESCENT_HEIGHT_M) / (_FAST_DESCENT_HEIGHT_M - _SLOW_DESCENT_HEIGHT_M)
        share = float(min(max(share, 0.0), 1.0))
        return p.MPC_LAND_SPEED + share * (p.MPC_Z_VEL_MAX_DN - p.MPC_LAND_SPEED)

    def _braking_point(self) -> Vec3:
        velocity = self._estimate.velocity
        speed = float(np.linalg.norm(velocity))
        if speed < 1e-3:
            return self._estimate.position.copy()
        distance = braking_distance(self._path, speed, self._parameters.MPC_ACC_HOR, self._dt)
        point: Vec3 = self._estimate.position + velocity / speed * distance
        return point

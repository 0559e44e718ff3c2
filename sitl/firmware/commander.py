"""What both autopilots' commanders have in common: their state, and what they report of it."""

import math
from abc import ABC, abstractmethod
from typing import ClassVar, Generic, Protocol, TypeVar

import numpy as np

from sitl.arrays import Vec3
from sitl.battery import Pack
from sitl.estimator import Estimator
from sitl.firmware.fence_watch import FenceWatch
from sitl.firmware.interface import Battery, FenceStatus, Health, Mode, Result, Severity, StatusText
from sitl.firmware.parameters import Parameters
from sitl.firmware.pilot import Pilot, Sticks
from sitl.plan.plans import Plans

P = TypeVar("P", bound=Parameters)


class Turning(Protocol):
    """What both autopilots' guidance can do."""

    def turn(self, yaw: float) -> None:
        """Turn to a heading (rad)."""
        ...


class Commander(ABC, Generic[P]):
    """The reporting half of `interface.Autopilot`.

    Args:
        parameters: what it flies by first.
        estimator: what it believes.
        pack: its battery.
        mode: in which it boots.

    Attributes:
        plans: mission, fence, rally points and home; of the navigator, as is the fence's state.
        dead_reckons_s: how long it believes its estimate without satellites (s).
    """

    plans: Plans
    dead_reckons_s: ClassVar[float]
    _fence: FenceWatch
    _guidance: Turning

    def __init__(self, parameters: P, estimator: Estimator, pack: Pack, mode: Mode) -> None:
        self._parameters = parameters
        self._estimator = estimator
        self._pack = pack
        self._mode = mode
        self._time_s = 0.0
        self._position_from_s = 0.0
        self._gps_lost_s: float | None = None
        self._armed = False
        self._terminated = False
        self._resets = int(estimator.resets[0])
        self._pilot = Pilot()
        self._was_piloted = False
        self._texts: list[StatusText] = []

    @abstractmethod
    def _reason_not_to_arm(self) -> str | None: ...

    @property
    def parameters(self) -> P:
        """What it flies by now."""
        return self._parameters

    @property
    def mode(self) -> Mode:
        """The mode that flies now, a failsafe's included."""
        return self._mode

    @property
    def intended_mode(self) -> Mode:
        """The same, but for an autopilot that tells them apart."""
        return self._mode

    @property
    def armed(self) -> bool:
        """Whether the rotors may turn."""
        return self._armed

    @property
    def battery(self) -> Battery:
        """As measured."""
        remaining, voltage, current = self._pack.state.tolist()
        return Battery(voltage_v=voltage, current_a=current, remaining=remaining)

    @property
    def health(self) -> Health:
        """Of the sensors and of the estimate; ready to arm when nothing would refuse it in this mode."""
        return Health(
            sensors_ok=True,
            gps_ok=self._gps_lost_s is None and self._time_s >= self._position_from_s,
            position_ok=self.position_ok,
            ready_to_arm=self._reason_not_to_arm() is None,
        )

    @property
    def fence_status(self) -> FenceStatus:
        """Whether the fence is on, and broken."""
        return self._fence.status

    def take_status_texts(self) -> list[StatusText]:
        """The texts since the last call, oldest first."""
        texts, self._texts = self._texts, []
        return texts

    def move_sticks(self, sticks: Sticks) -> None:
        """The pilot's sticks are there now."""
        self._pilot.move(sticks, self._time_s)

    def hear_satellites(self, *, heard: bool) -> None:
        """Whether the receiver has a fix now."""
        if heard:
            self._gps_lost_s = None
        elif self._gps_lost_s is None:
            self._gps_lost_s = self._time_s

    def turn(self, yaw: float) -> Result:
        """Turn to a heading (rad) while the path stays."""
        self._guidance.turn(yaw)
        return Result.ACCEPTED

    def wait_for_position(self, until_s: float) -> None:
        """Have no position before this time (s)."""
        self._position_from_s = until_s

    @property
    def position_ok(self) -> bool:
        """Whether it knows where it is."""
        north, east, down = self._estimator.position
        lost_s = self._gps_lost_s
        is_aided = lost_s is None or self._time_s - lost_s < self.dead_reckons_s
        return is_aided and self._time_s >= self._position_from_s and math.isfinite(north + east + down)

    @property
    def _known_velocity(self) -> Vec3:
        """What land detection goes by: the vertical velocity alone where there is no position."""
        velocity = self._estimator.velocity
        return velocity if self.position_ok else np.array((0.0, 0.0, velocity[2]))

    def _new_jump(self) -> tuple[Vec3, Vec3] | None:
        """By how much position and velocity (m, m/s) have jumped since the last look, if they have."""
        resets = int(self._estimator.resets[0])
        if resets == self._resets:
            return None
        self._resets = resets
        return self._estimator.jump[0], self._estimator.jump[1]

    def _say(self, severity: Severity, text: str) -> None:
        self._texts.append(StatusText(severity, text))

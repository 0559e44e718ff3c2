"""A vehicle in its conditions, moved through time: the one door to the simulator."""

from dataclasses import dataclass

import numpy as np

from sitl.arrays import Quaternion, Vec3
from sitl.battery import full_pack
from sitl.conditions import Conditions
from sitl.estimator import STEPS_PER_S, estimator
from sitl.firmware.interface import Firmware
from sitl.firmware.multirotor_tick import STEPS_PER_TICK, Plant, fly_tick
from sitl.firmware.px4 import Px4
from sitl.rigid_body import airframe, body_on_ground
from sitl.vehicle import Vehicle
from sitl.wind import wind

TICK_S = STEPS_PER_TICK / STEPS_PER_S
"""The step of `Simulation.advance` (s)."""


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """What really is, which no firmware sees.

    Attributes:
        time_s: since boot (s).
        position, velocity: NED (m, m/s).
        attitude: unit quaternion.
        rates: body rates (rad/s).
        wind: velocity of the air, NED (m/s).
    """

    time_s: float
    position: Vec3
    velocity: Vec3
    attitude: Quaternion
    rates: Vec3
    wind: Vec3


class Simulation:
    """Boots at time 0 on the ground at NED (0, 0, 0), heading north; the same seed gives the same bits.

    Attributes:
        vehicle, conditions: as given.
        link_rng: the random stream for the link's delays and losses, which are applied outside.
        truth_log: one `Truth` a tick when asked for, else empty.
    """

    def __init__(
        self, vehicle: Vehicle, conditions: Conditions, *, seed: int, record_truth: bool = False
    ) -> None:
        self.vehicle = vehicle
        self.conditions = conditions
        self.truth_log: list[Truth] = []
        self._record_truth = record_truth
        streams = np.random.SeedSequence(seed).spawn(3)
        self._wind_rng, self._estimator_rng, self.link_rng = map(np.random.default_rng, streams)
        self._ticks = 0
        self._plant = Plant(
            airframe(vehicle),
            body_on_ground(len(vehicle.rotors.layout)),
            full_pack(vehicle),
            wind(conditions.wind, self._wind_rng),
        )
        self._estimator = estimator(conditions.estimator, self._plant.body.motion, self._estimator_rng)
        self._autopilot = Px4(vehicle, self._estimator, self._plant.pack, TICK_S)

    @property
    def firmware(self) -> Firmware:
        """The autopilot on board."""
        return self._autopilot

    @property
    def time_s(self) -> float:
        """Time since boot (s), a whole number of ticks."""
        return self._ticks * STEPS_PER_TICK / STEPS_PER_S

    @property
    def truth(self) -> Truth:
        """A copy of what really is now."""
        motion = self._plant.body.motion.copy()
        return Truth(
            self.time_s, motion[0:3], motion[3:6], motion[6:10], motion[10:13], self._plant.air.now.copy()
        )

    def advance(self, until_s: float) -> None:
        """Run whole ticks up to `until_s` (s since boot)."""
        last_tick = int(np.floor(until_s / TICK_S + 1e-6))
        while self._ticks < last_tick:
            self._tick()

    def _tick(self) -> None:
        autopilot = self._autopilot
        first_step = self._ticks * STEPS_PER_TICK
        autopilot.update((first_step + STEPS_PER_TICK) / STEPS_PER_S)
        fly_tick(
            self._plant,
            self._estimator,
            autopilot.loops,
            autopilot.attitude_setpoint,
            autopilot.armed,
            autopilot.on_ground,
            first_step,
            self._wind_rng.standard_normal(5),
            self._estimator_rng.standard_normal((STEPS_PER_TICK, 12)),
        )
        self._ticks += 1
        if self._record_truth:
            self.truth_log.append(self.truth)

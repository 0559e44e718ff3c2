"""A vehicle in its conditions, moved through time: the one door to the simulator."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Quaternion, Vec3
from sitl.battery import Pack
from sitl.conditions import Conditions
from sitl.errors import ConfigError
from sitl.estimator import STEPS_PER_S, Estimator, estimator, reset
from sitl.estimator_errors import EstimatorErrors
from sitl.faults.disturbance import announce_jumps, discharge, disturb, disturbance
from sitl.faults.firmware_faults import begin_faults, keep_faults
from sitl.faults.kinds import Fault, Reboot
from sitl.faults.schedule import Schedule
from sitl.firmware.ardupilot import ArduPilot
from sitl.firmware.interface import Autopilot, Firmware
from sitl.firmware.px4 import Px4
from sitl.payload import laden
from sitl.plan.items import PlanKind
from sitl.plant import STEPS_PER_TICK, TICK_S, TickNoise, plant
from sitl.rigid_body import airframe
from sitl.vehicle import Vehicle, load_vehicle
from sitl.wind import wind

_FIRMWARE: dict[str, Callable[[Vehicle, Estimator, Pack], Firmware]] = {"px4": Px4, "ardupilot": ArduPilot}


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
    """Boots at time 0 on the ground, heading north; the same seed gives the same bits.

    It stands at `start`, north and east of the map's origin (m), and has no position for `boot_time_s` after
    each boot. With `motion` (position 3, velocity 3,
    attitude 4, body rates 3; NED, SI) it begins in flight instead, armed and following setpoints.

    Attributes:
        vehicle, conditions: as given.
        faults: what goes wrong, and when; those of the link are applied outside.
        link_rng, fault_rng: the random streams for the link's delays and losses, and for those of its faults.
        on_reboot: how a fault starts the autopilot anew; whoever serves its links does more than `reboot`.
        truth_log: one `Truth` a tick when asked for, else empty.
        load_changed_s: when in flight the vehicle last took or dropped its payload (s since boot).
    """

    def __init__(
        self,
        vehicle: Vehicle,
        conditions: Conditions,
        *,
        seed: int,
        record_truth: bool = False,
        start: tuple[float, float] = (0.0, 0.0),
        boot_time_s: float = 0.0,
        motion: Float[Array, "13"] | None = None,
        faults: Sequence[Fault] = (),
    ) -> None:
        self.vehicle = vehicle
        self.conditions = conditions
        self.truth_log: list[Truth] = []
        self._record_truth = record_truth
        streams = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(5))
        self._wind_rng, self._noise_rng, self.link_rng, self._wander_rng, self.fault_rng = streams
        self.faults = Schedule(faults)
        self.on_reboot: Callable[[], None] = self.reboot
        self._ticks = 0
        self._flight_ticks = 0
        self.load_changed_s: float | None = None
        self._laden, self._unladen = laden(vehicle, conditions), airframe(vehicle)
        self._plant = plant(vehicle, wind(conditions.wind, self._wind_rng), motion)
        if motion is None:
            self._plant.body.motion[0:2] = start
        errors = estimator_errors(vehicle, conditions)
        self._resets_per_tick = errors.resets_per_hour * TICK_S / 3600.0
        self._carry()
        self._estimator = estimator(errors, self._plant.body.motion, self._noise_rng, self._wander_rng)
        self._boot_time_s = boot_time_s
        self._firmware = self._boot()
        if motion is not None:
            self._firmware.begin_in_flight()

    def _boot(self) -> Firmware:
        firmware = _FIRMWARE[self.vehicle.firmware](self.vehicle, self._estimator, self._plant.pack)
        if self._boot_time_s > 0.0:
            firmware.wait_for_position(self.time_s + self._boot_time_s)
        return firmware

    def reboot(self) -> None:
        """Start the autopilot anew where the vehicle is: disarmed, with its parameters and plans."""
        before, self._firmware = self._firmware, self._boot()
        fresh = self._firmware.parameters.model_dump()
        for name, value in before.parameters.model_dump().items():
            if value != fresh[name]:
                self._firmware.set_parameter(name, value)
        for kind in PlanKind:
            self._firmware.plans.replace(kind, before.plans[kind].items)

    @property
    def firmware(self) -> Autopilot:
        """The autopilot on board."""
        return self._firmware

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
        if self._resets_per_tick and self._wander_rng.random() < self._resets_per_tick:
            reset(self._estimator, self._wander_rng)
        if not self.faults.is_idle:
            self._fail()
        self._age()
        noise = TickNoise(
            self._wind_rng.standard_normal(5),
            self._wander_rng.standard_normal((4, 3)),
            self._noise_rng.standard_normal((STEPS_PER_TICK, 12)),
        )
        self._firmware.fly_tick(self._plant, self._ticks * STEPS_PER_TICK, noise)
        self._ticks += 1
        if self._record_truth:
            self.truth_log.append(self.truth)

    def _age(self) -> None:
        """Change what the conditions change in the course of a flight."""
        if self._flight_ticks or self._plant.body.motion[2] < 0.0:
            self._flight_ticks += 1
            self._carry()
            self._plant.pack.sag[0] = self.conditions.battery.sag(self._flight_s)

    @property
    def _flight_s(self) -> float:
        """Time since it first left the ground (s)."""
        return self._flight_ticks * TICK_S

    def _carry(self) -> None:
        payload = self.conditions.payload
        frame = self._laden if payload is not None and payload.is_carried(self._flight_s) else self._unladen
        if frame is not self._plant.airframe:
            if self._flight_ticks:
                self.load_changed_s = self.time_s
            self._plant = self._plant._replace(airframe=frame)

    def _fail(self) -> None:
        """Let begin, go on and end what goes wrong."""
        change = self.faults.update(self.time_s, self._firmware)
        before = self._estimator.offset.copy()
        rotors = len(self._plant.effectiveness)
        disturb(self._plant, self._estimator, disturbance(self.faults.active, self.time_s, rotors))
        announce_jumps(self._estimator, change, before)
        discharge(self._plant, change)
        if any(isinstance(each.fault, Reboot) for each in change.begun):
            self.on_reboot()
        begin_faults(self._firmware, change)
        keep_faults(self._firmware, self.faults.active)


def estimator_errors(vehicle: Vehicle, conditions: Conditions) -> EstimatorErrors:
    """The errors of a vehicle's estimate in these conditions.

    Raises:
        ConfigError: the vehicle that stands in for one without own errors has none either.
    """
    errors = conditions.estimator
    if isinstance(errors, EstimatorErrors):
        return errors
    own = vehicle.estimator or load_vehicle(errors.without).estimator
    if own is None:
        raise ConfigError(conditions.name, "estimator.without", f"{errors.without} has no estimator section")
    return own

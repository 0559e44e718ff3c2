"""A vehicle without physics behind the MAVLink face, and a pymavlink peer in front of it."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from sitl.arrays import Vec3
from sitl.conditions import Conditions, LinkConditions
from sitl.faults.schedule import Schedule
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.interface import (
    AttitudeTarget,
    Battery,
    Estimate,
    FenceStatus,
    Health,
    Landed,
    Mode,
    Result,
    Setpoint,
    StatusText,
)
from sitl.firmware.parameters import Parameters
from sitl.firmware.pilot import Sticks
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.mavlink import Delivery, Link, MavlinkVehicle
from sitl.plan.mission import Mission, MissionRules
from sitl.plan.plans import Plans
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle, load_vehicle

PEER_SYSTEM, PEER_COMPONENT = 245, 191
BEBOP2 = load_vehicle("bebop2")
ARDUCOPTER = load_vehicle("arducopter_sitl")
BATTERY = Battery(voltage_v=12.0, current_a=3.5, remaining=0.83)
HEALTHY = Health(sensors_ok=True, gps_ok=True, position_ok=True, ready_to_arm=True)


def empty_plans(first: int = 0) -> Plans:
    """As on board of PX4; `first` is 1 for ArduPilot, where item 0 is home."""
    rules = MissionRules(first, waypoint_params=True, reports_every_item=True, climbs_first=True)
    return Plans(np.zeros(3), Mission(rules, lambda item: None), lambda kind: None)


@dataclass
class FakeFirmware:
    """Does at once what it is asked for, and keeps what it was given."""

    mode: Mode = Mode.HOLD
    intended_mode: Mode = Mode.HOLD
    armed: bool = False
    landed: Landed = Landed.ON_GROUND
    failsafe: bool = False
    battery: Battery = BATTERY
    health: Health = HEALTHY
    answer: Result = Result.ACCEPTED
    time_s: float = 0.0
    position: Vec3 = field(default_factory=lambda: np.array([1.0, 2.0, -3.0]))
    velocity: Vec3 = field(default_factory=lambda: np.array([0.5, -0.25, 0.125]))
    attitude: Any = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))
    resets: int = 0
    setpoints: list[Setpoint] = field(default_factory=list)
    plans: Plans = field(default_factory=lambda: empty_plans())
    fence_status: FenceStatus = field(default_factory=FenceStatus)
    calls: list[tuple[Any, ...]] = field(default_factory=list)
    texts: list[StatusText] = field(default_factory=list)
    parameters: Parameters = field(default_factory=Px4Parameters)

    @property
    def estimate(self) -> Estimate:
        rates = np.array([0.1, 0.2, 0.3])
        return Estimate(
            self.time_s,
            self.position,
            self.velocity,
            np.zeros(3),
            self.attitude,
            rates,
            self.position,
            self.resets,
        )

    @property
    def position_ok(self) -> bool:
        return self.health.position_ok

    @property
    def active_setpoint(self) -> Setpoint:
        return self.setpoints[-1] if self.setpoints else Setpoint()

    @property
    def attitude_target(self) -> AttitudeTarget:
        return AttitudeTarget(self.attitude, np.array([0.4, 0.5, 0.6]), 0.45)

    def set_parameter(self, name: str, value: float) -> None:
        self.parameters = self.parameters.changed(name, value)

    def start_mission(self, first: int | None = None) -> Result:
        return self._called("start_mission", first)

    def change_speed(self, speed_m_s: float) -> Result:
        return self._called("change_speed", speed_m_s)

    def enable_fence(self, *, enabled: bool) -> Result:
        return self._called("enable_fence", enabled)

    def arm(self, *, force: bool = False) -> Result:
        self.armed = self.armed or self.answer is Result.ACCEPTED
        return self._called("arm", force)

    def check(self) -> Result:
        return self._called("check")

    def disarm(self, *, force: bool = False) -> Result:
        self.armed = False
        return self._called("disarm", force)

    def set_mode(self, mode: Mode) -> Result:
        self.mode = mode
        return self._called("set_mode", mode)

    def terminate(self) -> Result:
        return self._called("terminate")

    def hear_ground_station(self, system_id: int) -> None:
        self.calls.append(("hear_ground_station", system_id))

    def hear_satellites(self, *, heard: bool) -> None:
        self.calls.append(("hear_satellites", heard))

    def move_sticks(self, sticks: Sticks) -> None:
        self.calls.append(("move_sticks", sticks))

    def turn(self, yaw: float) -> Result:
        return self._called("turn", yaw)

    def takeoff(self, altitude_m: float | None = None) -> Result:
        return self._called("takeoff", altitude_m)

    def reposition(self, position: Vec3, yaw: float) -> Result:
        return self._called("reposition", *position.tolist(), yaw)

    def offboard_setpoint(self, setpoint: Setpoint) -> None:
        self.setpoints.append(setpoint)

    def take_status_texts(self) -> list[StatusText]:
        texts, self.texts = self.texts, []
        return texts

    def _called(self, *call: Any) -> Result:
        self.calls.append(call)
        return self.answer


@dataclass
class FakeSimulation:
    firmware: FakeFirmware = field(default_factory=FakeFirmware)
    conditions: Conditions = field(default_factory=lambda: Conditions(name="ideal"))
    vehicle: Vehicle = BEBOP2
    link_rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    fault_rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    faults: Schedule = field(default_factory=Schedule)
    on_reboot: Callable[[], None] = lambda: None
    ticks: int = 0

    @property
    def time_s(self) -> float:
        return self.ticks / 100

    def advance(self, until_s: float) -> None:
        self.ticks = math.floor(until_s * 100 + 1e-6)
        self.firmware.time_s = self.time_s


def fake_vehicle(
    link: LinkConditions | None = None,
    *,
    seed: int = 1,
    links: tuple[Link, ...] | None = None,
    vehicle: Vehicle = BEBOP2,
) -> tuple[MavlinkVehicle, FakeFirmware]:
    conditions = Conditions(name="test", link=link or LinkConditions())
    simulation = FakeSimulation(conditions=conditions, vehicle=vehicle, link_rng=np.random.default_rng(seed))
    if vehicle.firmware == "ardupilot":
        simulation.firmware.parameters = ArduPilotParameters()
    flying = MavlinkVehicle(cast(Simulation, simulation), links=links)
    return flying, simulation.firmware


def encode(message: Any, system: int = PEER_SYSTEM, component: int = PEER_COMPONENT) -> bytes:
    return bytes(message.pack(mavlink.MAVLink(None, system, component)))


def parse(deliveries: list[Delivery]) -> list[Any]:
    parser = mavlink.MAVLink(None)
    return [message for delivery in deliveries for message in parser.parse_buffer(delivery.data) or []]


def answers(vehicle: MavlinkVehicle, *messages: Any) -> list[Any]:
    """What comes back on messages, telemetry left out: all streams are stopped for it."""
    for session in vehicle._sessions.values():
        session.streams._due_us.clear()
    for message in messages:
        vehicle.receive(encode(message))
    return parse(vehicle.advance(vehicle.simulation.time_s + 0.01))


def command_long(command: int, *params: float, system: int = 1, component: int = 1) -> Any:
    seven = [*params, *[0.0] * (7 - len(params))]
    return mavlink.MAVLink_command_long_message(system, component, command, 0, *seven)

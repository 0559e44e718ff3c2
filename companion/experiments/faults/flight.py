"""One flight in virtual time in which something fails, watched until the vehicle is down or at rest."""

import asyncio
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from companion import clock
from companion.arrays import Times, Vec3s
from companion.autopilot import detect
from companion.experiments.faults.catalogue import Failure
from companion.experiments.faults.sabotage import Sabotage, Saboteur, hold_up, sabotaged
from companion.experiments.faults.watch import Watch
from companion.experiments.simulated_flights import Scenario
from companion.flight.fence import Fence
from companion.flight.flight import After, FlightPlan, fly
from companion.flight.guard import GuardLimits
from companion.flight.recorder import FlightRecorder
from companion.learning.inverse_network import InverseNetwork
from companion.link import connect, start_telemetry
from companion.link.address import Simulated
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.simulated import SimulatedTransport
from sitl.faults.kinds import UplinkLost
from sitl.faults.reading import parse_fault
from sitl.firmware.interface import Mode

_LOOK_EVERY_S = 0.02
_OBSERVED_S = 30.0
"""After the fault, unless the vehicle is down before."""
_DEAD_AFTER_S = 0.02
"""From the last frame of a killed process to the end of what it would still have sent."""
_POSITION_ALONE = 0b110111111000
"""Type mask of a setpoint."""
_SAMPLE_EVERY_S = 0.05
_SECOND_COMPANION_S = 3.0
_SECOND_COMPANION_EVERY_S = 0.05
_LATER_BY_SEED_S = 0.37


class Phase(StrEnum):
    """When something fails."""

    TAKEOFF = "takeoff"
    TRACKING = "tracking"
    LANDING = "landing"

    @property
    def begins_with(self) -> str:
        """How the companion announces it."""
        return {Phase.TAKEOFF: "taking off", Phase.TRACKING: "tracking", Phase.LANDING: "landing"}[self]

    @property
    def strikes_after_s(self) -> float:
        """How long after that announcement it strikes first (s)."""
        return {Phase.TAKEOFF: 4.5, Phase.TRACKING: 2.0, Phase.LANDING: 0.5}[self]


@dataclass(frozen=True, eq=False)
class FaultFlight:
    """What is to be flown, and what fails in it.

    Attributes:
        scenario: the flight without the fault; ends with a landing.
        failure: what fails.
        phase: when.
    """

    scenario: Scenario
    failure: Failure
    phase: Phase


@dataclass(frozen=True, eq=False)
class Course:
    """What happened, on the clock of the vehicle (s since boot).

    Attributes:
        struck_s: when the fault began; None if the flight was over before.
        error: what ended the flight; None when it came to its end.
        events: what the companion noted from the fault on.
        warnings: what the autopilot warned of from the fault on.
        modes: when which flight mode began.
        desired_s, desired: when the companion wanted the vehicle where, NED (m).
        time_s, position, velocity: where it was in truth, NED (m, m/s), every 10 ms.
        fence: of the guard, around the takeoff point.
    """

    struck_s: float | None
    error: BaseException | None
    events: list[tuple[float, str]]
    warnings: list[tuple[float, str]]
    modes: list[tuple[float, Mode]]
    desired_s: Times
    desired: Vec3s
    time_s: Times
    position: Vec3s
    velocity: Vec3s
    fence: Fence


class KilledError(Exception):
    """The companion's process was ended."""


def fly_with_fault(flight: FaultFlight) -> Course:
    """Fly it in virtual time; whatever becomes of the companion, the vehicle is watched on."""
    return clock.run(_Run(flight).fly(), virtual=True)


@dataclass(eq=False)
class _Run:
    """A flight under way, and who lets it fail."""

    flight: FaultFlight
    recorder: FlightRecorder = field(default_factory=FlightRecorder)
    saboteur: Saboteur = field(init=False)
    fence: Fence = field(init=False)
    watch: Watch = field(init=False)
    connection: Connection = field(init=False)
    epoch_s: float = 0.0
    task: asyncio.Task[Course] | None = None
    awaited: bool = False
    struck_s: float | None = None

    async def fly(self) -> Course:
        """To its end, and on until the vehicle is down or was watched for long enough."""
        failure, scenario = self.flight.failure, self.flight.scenario
        self.saboteur = Saboteur(failure.sabotage, failure.amount)
        plan = self._plan()
        address = Simulated(scenario.vehicle, scenario.conditions, scenario.seed, record_truth=True)
        error: BaseException | None = None
        try:
            async with connect(address) as self.connection:
                self._meet(self.connection)
                await self._fly(plan)
        except Exception as failed:  # whatever it was, the vehicle flies on
            error = failed
        self._watch_on()
        return self._course(error)

    def _plan(self) -> FlightPlan:
        scenario = self.flight.scenario
        if isinstance(scenario.network, InverseNetwork):
            scenario = replace(scenario, network=sabotaged(scenario.network, self.saboteur))
        times_s = np.arange(0.0, scenario.trajectory.duration_s, _SAMPLE_EVERY_S)
        self.fence = Fence.around(scenario.trajectory.sample(times_s).position)
        limits = GuardLimits(fence=self.fence)
        return replace(scenario.plan(), after=After.LAND, limits=limits)

    def _meet(self, connection: Connection) -> None:
        transport = connection.transport
        assert isinstance(transport, SimulatedTransport)
        self.epoch_s = transport.epoch_s
        self.watch = Watch(transport.vehicle)
        connection.spawn(self._look())

    async def _look(self) -> None:
        while True:
            self.watch.look()
            await asyncio.sleep(_LOOK_EVERY_S)

    async def _fly(self, plan: FlightPlan) -> None:
        self.task = asyncio.current_task()
        telemetry = await start_telemetry(self.connection)
        autopilot = await detect(self.connection, telemetry)
        provenance = self.flight.scenario.provenance()
        try:
            await fly(
                plan,
                autopilot,
                telemetry,
                provenance=provenance,
                recorder=self.recorder,
                announce=self._announced,
            )
        except asyncio.CancelledError:
            if self.saboteur.what is not Sabotage.PROCESS_KILLED or self.task is None:
                raise
            self.task.uncancel()
            raise KilledError("the process was killed") from None

    def _announced(self, text: str) -> None:
        """The companion says something: perhaps that the phase begins."""
        phase = self.flight.phase
        if not self.awaited and text.startswith(phase.begins_with):
            self.awaited = True
            delay_s = phase.strikes_after_s + _LATER_BY_SEED_S * self.flight.scenario.seed
            asyncio.get_running_loop().call_later(delay_s, self._strike)

    def _strike(self) -> None:
        simulation = self.watch.vehicle.simulation
        self.struck_s = simulation.time_s
        self.saboteur.struck = True
        if self.flight.failure.fault:
            simulation.faults.inject(parse_fault(self.flight.failure.fault))
        match self.saboteur.what:
            case Sabotage.LOOP_STALLED:
                hold_up(self.saboteur.amount)
            case Sabotage.PROCESS_KILLED:
                simulation.faults.inject(UplinkLost())
                assert self.task is not None
                asyncio.get_running_loop().call_later(_DEAD_AFTER_S, self.task.cancel)
            case Sabotage.SECOND_COMPANION:
                self.connection.spawn(self._send_beside(self.saboteur.amount))

    async def _send_beside(self, offset_m: float) -> None:
        """Setpoints of another component of our system."""
        vehicle = self.watch.vehicle
        other = mavlink.MAVLink(None, srcSystem=1, srcComponent=mavlink.MAV_COMP_ID_ONBOARD_COMPUTER2)
        north, east, down = (vehicle.simulation.truth.position + np.array((0.0, offset_m, 0.0))).tolist()
        message = mavlink.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, mavlink.MAV_FRAME_LOCAL_NED, _POSITION_ALONE, north, east, down, 0, 0, 0, 0, 0, 0, 0, 0
        )
        for _ in range(round(_SECOND_COMPANION_S / _SECOND_COMPANION_EVERY_S)):
            vehicle.receive(message.pack(other))
            await asyncio.sleep(_SECOND_COMPANION_EVERY_S)

    def _watch_on(self) -> None:
        """The companion is gone; what becomes of the vehicle."""
        vehicle = self.watch.vehicle
        self.watch.look()
        if self.struck_s is None:
            return
        while not self.watch.is_down and vehicle.simulation.time_s < self.struck_s + _OBSERVED_S:
            vehicle.advance(vehicle.simulation.time_s + _LOOK_EVERY_S)
            self.watch.look()

    def _course(self, error: BaseException | None) -> Course:
        struck_s = np.inf if self.struck_s is None else self.struck_s
        truths = self.watch.vehicle.simulation.truth_log
        tracking = self.recorder.recording(self.flight.scenario.provenance()).tracking
        desired_s = np.zeros(0) if tracking is None else tracking.time_s - self.epoch_s
        desired = np.zeros((0, 3)) if tracking is None else tracking.desired_position
        events = [(time_s - self.epoch_s, text) for time_s, text in self.recorder.events]
        return Course(
            struck_s=self.struck_s,
            error=error,
            events=[event for event in events if event[0] >= struck_s],
            warnings=[warning for warning in self.watch.warnings if warning[0] >= struck_s],
            modes=self.watch.modes,
            desired_s=desired_s,
            desired=desired,
            time_s=np.array([truth.time_s for truth in truths]),
            position=np.array([truth.position for truth in truths]),
            velocity=np.array([truth.velocity for truth in truths]),
            fence=self.fence,
        )

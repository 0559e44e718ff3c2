"""The simulated vehicle as its MAVLink peers see it: bytes in, bytes out, no sockets and no waiting."""

import heapq
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import Literal

from sitl.conditions import load_conditions
from sitl.faults.kinds import Fault
from sitl.firmware.interface import StatusText
from sitl.mavlink import missions, parameters, services
from sitl.mavlink.ardupilot import ARDUPILOT
from sitl.mavlink.channel import Channel
from sitl.mavlink.flavour import Flavour
from sitl.mavlink.frames import Encoder, Message, decode
from sitl.mavlink.link_faults import LinkFaults
from sitl.mavlink.links import Link, Streams
from sitl.mavlink.mission_telemetry import MissionNews
from sitl.mavlink.mission_upload import Uploads
from sitl.mavlink.px4 import PX4
from sitl.mavlink.session import Session
from sitl.mavlink.signing import Signing
from sitl.mavlink.telemetry import report, written
from sitl.plant import TICK_S
from sitl.simulation import Simulation
from sitl.vehicle import load_vehicle

_ROUNDING_S = 1e-9
_FLAVOURS: Mapping[str, Flavour] = {"px4": PX4, "ardupilot": ARDUPILOT}


@dataclass(frozen=True, slots=True)
class Delivery:
    """A frame on its way to the peer of `link`, where it arrives at `time_s` (s, time of the simulation)."""

    time_s: float
    link: Link
    data: bytes


class MavlinkVehicle:
    """A simulated vehicle on one or more MAVLink links.

    Args:
        simulation: the vehicle itself; from now on time moves only in `advance`.
        system_id: MAVLink id of the vehicle (1 to 255).
        links: the links that there are; the first of its firmware's unless given.
        signing_key: 32 bytes with which all frames are signed; others are not believed. None for no signing.
    """

    def __init__(
        self,
        simulation: Simulation,
        *,
        system_id: int = 1,
        links: Sequence[Link] | None = None,
        signing_key: bytes | None = None,
    ) -> None:
        self.simulation = simulation
        self._flavour = _FLAVOURS[simulation.vehicle.firmware]
        self.system_id = system_id
        simulation.firmware.set_parameter(self._flavour.system_id_parameter, system_id)
        self._rotors = len(simulation.vehicle.rotors.layout)
        self.status_texts: deque[StatusText] = deque(maxlen=100)
        """The newest texts that the firmware gave out, for whoever watches beside the links."""
        conditions = simulation.conditions.link
        self._way_out = Channel(
            conditions.telemetry_latency_s,
            conditions.telemetry_jitter_s,
            conditions.telemetry_loss_fraction,
            simulation.link_rng,
            duplicates=conditions.telemetry_duplicate_fraction,
            overtaken=conditions.telemetry_overtaken_fraction,
        )
        self._way_in = Channel(
            conditions.setpoint_latency_s,
            conditions.setpoint_jitter_s,
            conditions.setpoint_loss_fraction,
            simulation.link_rng.spawn(1)[0],
            duplicates=conditions.setpoint_duplicate_fraction,
            overtaken=conditions.setpoint_overtaken_fraction,
        )
        self._faults = LinkFaults(simulation.faults, simulation.fault_rng)
        simulation.on_reboot = self.reboot
        self._order = count()
        self._on_the_way_in: list[tuple[float, int, Session, bytes]] = []
        self._on_the_way_out: list[Delivery] = []
        self._booted_s = 0.0
        self._reboots = False
        self._uploads = Uploads()
        self._mission_news = MissionNews(self._flavour)
        self._signing = Signing(signing_key) if signing_key else None
        self._sessions = self._open_all(links or self._flavour.links[:1])

    @property
    def links(self) -> Sequence[Link]:
        """The links that there are."""
        return tuple(self._sessions)

    @property
    def mode_name(self) -> str:
        """The flight mode, by its autopilot's own name."""
        mode = self.simulation.firmware.mode
        return self._flavour.mode_names.get(mode, mode.name)

    def _open_all(self, links: Iterable[Link]) -> dict[Link, Session]:
        return {link: self._open(link, link_id) for link_id, link in enumerate(links)}

    def _open(self, link: Link, link_id: int) -> Session:
        return Session(
            system_id=self.system_id,
            rotors=self._rotors,
            firmware=self.simulation.firmware,
            flavour=self._flavour,
            streams=Streams(link.rates_hz),
            send=partial(self._send, link, Encoder(self.system_id, link_id, self._signing)),
            reboot=self._reboot_soon,
            uploads=self._uploads,
            faults=self.simulation.faults,
        )

    def reboot(self) -> None:
        """Start the autopilot anew, now, in flight too: disarmed, with its parameters and plans.

        Its clock begins at 0, its links carry their default streams, what was on the way to it is lost.
        """
        self._reboots = False
        self.simulation.reboot()
        self._booted_s = self.simulation.time_s
        self.system_id = getattr(self.simulation.firmware.parameters, self._flavour.system_id_parameter)
        self._on_the_way_in.clear()
        self._uploads = Uploads()
        self._sessions = self._open_all(self._sessions)

    def _reboot_soon(self) -> None:
        self._reboots = True

    def _send(self, link: Link, encoder: Encoder, message: Message) -> None:
        frame = encoder.encode(message)
        arrivals_s = self._way_out.arrivals_s(self.simulation.time_s)
        for arrival_s, data in self._faults.way_out(arrivals_s, frame):
            self._on_the_way_out.append(Delivery(arrival_s, link, data))

    def receive(self, data: bytes, link: Link | None = None) -> None:
        """Take a datagram that the peer of `link` sent now; the vehicle has it when it has arrived.

        Without a link it came on the first. Bytes that are no valid frame are skipped.
        """
        session = self._sessions[link or self.links[0]]
        for arrival_s in self._faults.way_in(self._way_in.arrivals_s(self.simulation.time_s)):
            heapq.heappush(self._on_the_way_in, (arrival_s, next(self._order), session, data))
        self._take_arrived(self.simulation.time_s)

    def advance(self, until_s: float) -> list[Delivery]:
        """Run the simulation up to `until_s` (s), in whole ticks.

        Returns:
            The frames that were sent meanwhile and not lost, by time of arrival. That may lie after
            `until_s`, and before the arrival of a frame that an earlier call returned.
        """
        simulation = self.simulation
        while simulation.time_s + TICK_S <= until_s + _ROUNDING_S:
            self._take_arrived(simulation.time_s)
            simulation.advance(simulation.time_s + TICK_S)
            self._tell()
        sent, self._on_the_way_out = self._on_the_way_out, []
        return sorted(sent, key=lambda delivery: delivery.time_s)

    def _take_arrived(self, now_s: float) -> None:
        while self._on_the_way_in and self._on_the_way_in[0][0] <= now_s + _ROUNDING_S:
            *_, session, data = heapq.heappop(self._on_the_way_in)
            session.time_s = now_s - self._booted_s
            for message in decode(data):
                if self._signing is None or self._signing.believes(message):
                    services.handle(session, self._faults.heard(message))
        if self._reboots:
            self.reboot()

    def _tell(self) -> None:
        """Send on every link what is due."""
        firmware, now_s = self.simulation.firmware, self.simulation.time_s - self._booted_s
        state = self._faults.told(report(firmware, self._flavour, self.system_id, self._rotors, now_s))
        texts = firmware.take_status_texts()
        self.status_texts.extend(texts)
        news = self._mission_news.take(state)
        for session in self._sessions.values():
            session.time_s = now_s
            for text in texts:
                session.say(text.severity, text.text)
            for message in news:
                session.send(message)
            missions.keep_time(session)
            parameters.send_backlog(session)
            for message_id in session.streams.take_due(state.time_us):
                due = written(message_id, state)
                if due is not None and not self._faults.withholds(due):
                    session.send(due)


def open_vehicle(
    vehicle: str | Path,
    conditions: str | Path = "ideal",
    *,
    seed: int = 0,
    system_id: int = 1,
    record_truth: bool = False,
    links: Sequence[Link] | None = None,
    autopilot: Literal["px4", "ardupilot"] | None = None,
    start: tuple[float, float] = (0.0, 0.0),
    boot_time_s: float = 0.0,
    signing_key: bytes | None = None,
    faults: Sequence[Fault] = (),
) -> MavlinkVehicle:
    """A vehicle on the ground, at time 0.

    Args:
        vehicle: name of a file in `config/vehicles`, or a path.
        conditions: name of a file in `config/conditions`, or a path.
        seed: of everything random.
        system_id: MAVLink id of the vehicle (1 to 255).
        record_truth: whether the simulation keeps the true states.
        links: the links that there are; the first of its firmware's unless given.
        autopilot: what is to fly it, instead of the firmware in its file.
        start: where it stands, north and east of the map's origin (m).
        boot_time_s: for how long after a boot it has no position (s).
        signing_key: 32 bytes with which all frames are signed; others are not believed. None for no signing.
        faults: what goes wrong, and when.

    Raises:
        ConfigError: a file is missing or wrong.
    """
    airframe = load_vehicle(vehicle)
    if autopilot is not None:
        airframe = airframe.model_copy(update={"firmware": autopilot})
    simulation = Simulation(
        airframe,
        load_conditions(conditions),
        seed=seed,
        record_truth=record_truth,
        start=start,
        boot_time_s=boot_time_s,
        faults=faults,
    )
    return MavlinkVehicle(simulation, system_id=system_id, links=links, signing_key=signing_key)

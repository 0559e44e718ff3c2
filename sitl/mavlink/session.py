"""One link of the vehicle as its message handlers see it."""

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from pymavlink.dialects.v20 import common as mavlink

from sitl.faults.schedule import Schedule
from sitl.firmware.interface import Autopilot, Result, Severity
from sitl.mavlink.flavour import Flavour
from sitl.mavlink.frames import Message
from sitl.mavlink.links import Streams
from sitl.mavlink.mission_upload import Uploads
from sitl.mavlink.telemetry import Report, report

COMPONENT_ID = mavlink.MAV_COMP_ID_AUTOPILOT1
_TEXT_LENGTH = 50


@dataclass
class Session:
    """What a handler needs to answer a message.

    Attributes:
        system_id: the vehicle's.
        rotors: how many the vehicle has.
        firmware: the autopilot.
        flavour: how that speaks.
        streams: what this link carries, and how often.
        send: put a message on this link.
        reboot: start the vehicle's autopilot anew, once everything that has arrived is answered.
        uploads: of plans; the same for all links of a vehicle.
        faults: of the vehicle, which a peer may inject.
        time_s: time since boot (s), of the simulation.
        backlog: parameters that are yet to be sent, with their indices.
    """

    system_id: int
    rotors: int
    firmware: Autopilot
    flavour: Flavour
    streams: Streams
    send: Callable[[Message], None]
    reboot: Callable[[], None]
    uploads: Uploads
    faults: Schedule
    time_s: float = 0.0
    backlog: deque[tuple[int, str]] = field(default_factory=deque)
    _long_texts: int = 0

    def report(self) -> Report:
        """The vehicle's state now."""
        return report(self.firmware, self.flavour, self.system_id, self.rotors, self.time_s)

    def accepts(self, target_system: int, target_component: int) -> bool:
        """Whether a message to this target is meant for the vehicle; 0 is everyone."""
        return target_system in (0, self.system_id) and target_component in (0, COMPONENT_ID)

    def result(self, answer: Result) -> int:
        """MAV_RESULT of an answer of the firmware."""
        return self.flavour.results[answer]

    def say(self, severity: Severity, text: str) -> None:
        """Send a status text; one longer than 50 bytes travels in chunks with a common id."""
        encoded = text.encode()
        if len(encoded) <= _TEXT_LENGTH:
            self.send(mavlink.MAVLink_statustext_message(severity.value, encoded))
            return
        self._long_texts = self._long_texts % 65535 + 1
        for sequence, chunk in enumerate(_chunks(encoded)):
            self.send(mavlink.MAVLink_statustext_message(severity.value, chunk, self._long_texts, sequence))


def _chunks(text: bytes) -> Iterable[bytes]:
    """Pieces of at most 50 bytes; the last one is shorter, which is how a receiver knows it."""
    for start in range(0, len(text) + 1, _TEXT_LENGTH):
        yield text[start : start + _TEXT_LENGTH]

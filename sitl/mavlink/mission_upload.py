"""One upload of a plan, from MISSION_COUNT to MISSION_ACK, as the vehicle conducts it.

https://mavlink.io/en/services/mission.html#uploading_mission: the vehicle asks for one item after the other,
and again when nothing comes.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink.frames import Message
from sitl.plan.items import Item, PlanKind

_DUPLICATE_S = 0.25
"""How much later a duplicate of a frame may come."""

Peer = tuple[int, int]
"""System and component id."""


@dataclass(frozen=True, slots=True)
class MissionWire:
    """How an autopilot conducts plan transfers.

    Attributes:
        request: the message with which it asks for an item.
        retry_s: when it asks again (s).
        timeout_s: when it gives up (s).
        capacity: how many items of a kind it keeps.
        atomic: the kinds of plans of which the former one stays until the last item is there.
        refuses_out_of_turn: whether an item that was not asked for yet is answered; else it is ignored.
        has_home: whether item 0 of a mission is home.
        busy: MAV_MISSION_RESULT for whoever asks while another's upload is under way.
        check: MAV_MISSION_RESULT of an item.
        frames: MAV_FRAME in which it gives items back, by the one in which they came.
        has_ids: whether it tells the opaque ids of plans.
    """

    request: type[mavlink.MAVLink_mission_request_message] | type[mavlink.MAVLink_mission_request_int_message]
    retry_s: float
    timeout_s: float
    capacity: Mapping[PlanKind, int]
    atomic: frozenset[PlanKind]
    refuses_out_of_turn: bool
    has_home: bool
    busy: int
    check: Callable[[PlanKind, Item], int]
    frames: Mapping[int, int]
    has_ids: bool


@dataclass
class Upload:
    """An upload that is under way.

    Attributes:
        peer: who uploads.
        kind: what.
        send: the link that it came on.
        items: the plan as it will be: what has come, and around it what was there before.
        expected: number of the item that is asked for.
        end: number after the last one that will be asked for.
        current: the item that the peer marked as current.
        began_s: when it began (s).
        heard_s, asked_s: when the peer last sent something useful, and was last asked (s).
    """

    wire: MissionWire
    peer: Peer
    kind: PlanKind
    send: Callable[[Message], None]
    expected: int
    end: int
    items: list[Item] = field(default_factory=list)
    current: int = 0
    began_s: float = 0.0
    heard_s: float = 0.0
    asked_s: float = 0.0

    def begins_with(self, kind: int, count: int, now_s: float) -> bool:
        """Whether this MISSION_COUNT is the one that began it, once more, and not another beginning."""
        same = (kind, count) == (self.kind, self.end)
        return same and (self.expected == 0 or now_s - self.began_s < _DUPLICATE_S)

    def ask(self, now_s: float) -> None:
        """Ask for the next item."""
        self.asked_s = now_s
        self.send(self.wire.request(*self.peer, self.expected, self.kind))

    def take(self, item: Item, now_s: float) -> None:
        """Keep the item that was asked for."""
        self.heard_s = now_s
        self.items[self.expected : self.expected + 1] = [item]
        self.expected += 1

    @property
    def complete(self) -> bool:
        """Whether all items have come."""
        return self.expected >= self.end

    def has_timed_out(self, now_s: float) -> bool:
        """Whether to give up; asks again when that is due."""
        if now_s - self.heard_s > self.wire.timeout_s:
            return True
        if now_s - self.asked_s > self.wire.retry_s:
            self.ask(now_s)
        return False


@dataclass
class Uploads:
    """What the links of a vehicle share: one upload at a time, and which was the last.

    Attributes:
        active: the upload under way.
        last: the one that was completed last.
    """

    active: Upload | None = None
    last: Upload | None = None

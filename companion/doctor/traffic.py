"""All that a link carries, whoever sent it: measured beside the connection, from the same bytes."""

from collections import defaultdict
from collections.abc import Mapping
from itertools import pairwise
from statistics import pstdev

from companion import clock
from companion.doctor.observation import Loss, Peer, Stream
from companion.doctor.sequence import SequenceCount
from companion.link.dialect import mavlink
from companion.link.framing import Frame, FrameCounts, FrameSplitter, decode
from companion.link.lasting import OpenTransport
from companion.link.transport import Receiver, Transport


class Traffic:
    """Counts and times frames by who sent them; a `Receiver` put before another.

    Attributes:
        peers: who heartbeats, by system and component id.
        opened: whether the link could be opened.
    """

    def __init__(self) -> None:
        self.peers: dict[tuple[int, int], Peer] = {}
        self.opened = False
        self._splitter = FrameSplitter()
        self.restart()

    def restart(self) -> None:
        """Measure from here on."""
        self.began_s = clock.now()
        self._arrivals: defaultdict[tuple[int, int, int], list[float]] = defaultdict(list)
        self._sequences: defaultdict[tuple[int, int], SequenceCount] = defaultdict(SequenceCount)

    def watching(self, opener: OpenTransport) -> OpenTransport:
        """`opener`, with every byte that arrives counted here too."""

        async def opened(receiver: Receiver) -> Transport:
            transport = await opener(_Watched(self, receiver))
            self.opened = True
            return transport

        return opened

    @property
    def counts(self) -> FrameCounts:
        """What the link carried since it was opened."""
        return self._splitter.counts

    @property
    def losses(self) -> Mapping[tuple[int, int], Loss]:
        """Since the restart, by system and component id."""
        return {sender: count.loss for sender, count in self._sequences.items()}

    def streams(self, system_id: int, component_id: int) -> Mapping[str, Stream]:
        """What one component sent since the restart, by the message's name."""
        now_s = clock.now()
        return {
            mavlink.mavlink_map[message_id].msgname: _stream(times, self.began_s, now_s)
            for (system, component, message_id), times in sorted(self._arrivals.items())
            if (system, component) == (system_id, component_id)
        }

    def add(self, data: bytes) -> None:
        """Take bytes as they arrive."""
        now_s = clock.now()
        for frame in self._splitter.feed(data):
            self._arrivals[frame.system_id, frame.component_id, frame.message_id].append(now_s)
            self._sequences[frame.system_id, frame.component_id].add(frame.sequence)
            if frame.message_id == mavlink.MAVLINK_MSG_ID_HEARTBEAT:
                self._notice(frame)

    def _notice(self, frame: Frame) -> None:
        message = decode(frame)
        assert isinstance(message, mavlink.MAVLink_heartbeat_message)
        sender = (frame.system_id, frame.component_id)
        self.peers[sender] = Peer(*sender, message.type, message.autopilot)


class _Watched:
    """A receiver whose bytes are counted."""

    def __init__(self, traffic: Traffic, receiver: Receiver) -> None:
        self._traffic = traffic
        self._receiver = receiver

    def bytes_received(self, data: bytes) -> None:
        self._traffic.add(data)
        self._receiver.bytes_received(data)

    def transport_lost(self, error: Exception) -> None:
        self._receiver.transport_lost(error)


def _stream(times: list[float], began_s: float, now_s: float) -> Stream:
    """Of the arrivals `times`, measured from `began_s` to `now_s` (s)."""
    gaps = [later - earlier for earlier, later in pairwise(times)]
    whole_s = max(now_s - began_s, 1e-9)
    longest = max([*gaps, now_s - times[-1], times[0] - began_s])
    return Stream(len(times) / whole_s, pstdev(gaps) if gaps else 0.0, longest)

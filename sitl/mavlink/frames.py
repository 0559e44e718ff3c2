"""MAVLink frames cut out of datagrams and checked; pymavlink knows the messages."""

from typing import Protocol

from pymavlink.dialects.v20 import common as mavlink

Message = mavlink.MAVLink_message

_MARKERS = (mavlink.PROTOCOL_MARKER_V1, mavlink.PROTOCOL_MARKER_V2)
_CHECKSUM_LENGTH = 2
_DECODER = mavlink.MAVLink(None)


def decode(datagram: bytes) -> list[Message]:
    """The whole and valid messages in `datagram`, in order; whatever lies between them is skipped.

    Frames of MAVLink 1 and 2 are taken, signed ones without a look at the signature. After a broken frame
    the search goes on at its second byte, so that stray bytes never hide the frames behind them.
    """
    messages = []
    start = 0
    while start < len(datagram):
        frame = _frame_at(datagram, start)
        message = _message_in(frame) if frame else None
        if message is None:
            start += 1
        else:
            messages.append(message)
            start += len(frame)
    return messages


def whole_frames(stream: bytes) -> int:
    """How many bytes of a stream there are before a frame whose end is yet to come."""
    start = 0
    while start < len(stream):
        length = _frame_length(stream, start)
        if length is None or start + length > len(stream):
            return start
        start += length or 1
    return start


def _frame_at(datagram: bytes, start: int) -> bytes:
    """The bytes of the frame that begins at `start`; empty where none does, or where its end is missing."""
    length = _frame_length(datagram, start) or 0
    frame = datagram[start : start + length]
    return frame if len(frame) == length else b""


def _frame_length(stream: bytes, start: int) -> int | None:
    """Bytes of the frame that begins at `start`; 0 where none does, None where too few bytes say so."""
    if stream[start] not in _MARKERS:
        return 0
    if start + 2 >= len(stream):
        return None
    payload_length, flags = stream[start + 1], stream[start + 2]
    if stream[start] == mavlink.PROTOCOL_MARKER_V1:
        return mavlink.HEADER_LEN_V1 + payload_length + _CHECKSUM_LENGTH
    if flags & ~mavlink.MAVLINK_IFLAG_SIGNED:
        return 0  # flags that a receiver does not know forbid it to read on
    signature_length = mavlink.MAVLINK_SIGNATURE_BLOCK_LEN if flags else 0
    return mavlink.HEADER_LEN_V2 + payload_length + _CHECKSUM_LENGTH + signature_length


def _message_in(frame: bytes) -> Message | None:
    try:
        message = _DECODER.decode(bytearray(frame))
    except mavlink.MAVError:
        return None
    # without the message's definition its checksum cannot be checked
    return None if isinstance(message, mavlink.MAVLink_unknown) else message


class Signatures(Protocol):
    """What signatures need; `sitl.mavlink.signing` has it."""

    key: bytes

    def next_timestamp(self) -> int:
        """That of the next frame to be signed (10 µs since 2015)."""
        ...


class Encoder:
    """Turns the messages of one component into MAVLink 2 frames, numbered in sequence on one link.

    Args:
        system_id: of the vehicle.
        link_id: of the link, for signatures.
        signatures: what they are made with; without it, frames are not signed.
    """

    def __init__(self, system_id: int, link_id: int = 0, signatures: Signatures | None = None) -> None:
        self._protocol = mavlink.MAVLink(None, system_id, mavlink.MAV_COMP_ID_AUTOPILOT1)
        self._signatures = signatures
        if signatures is not None:
            self._protocol.signing.secret_key = signatures.key
            self._protocol.signing.sign_outgoing = True
            self._protocol.signing.link_id = link_id

    def encode(self, message: Message) -> bytes:
        """The next frame."""
        if self._signatures is not None:
            self._protocol.signing.timestamp = self._signatures.next_timestamp()
        frame = message.pack(self._protocol)
        self._protocol.seq = (self._protocol.seq + 1) % 256
        return frame

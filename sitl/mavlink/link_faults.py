"""What faults do to the frames between vehicle and companion, and to what they say."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from sitl.faults import kinds
from sitl.faults.schedule import Active, Schedule
from sitl.mavlink.channel import Channel
from sitl.mavlink.frames import Message
from sitl.mavlink.telemetry import Report

_SETPOINTS = (
    mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED,
    mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT,
)
_WRONG_BYTES = 3


class LinkFaults:
    """The faults of a schedule that concern what is sent; every method is the identity without one.

    Args:
        schedule: what is there when.
        rng: of this link's faults alone.
    """

    def __init__(self, schedule: Schedule, rng: np.random.Generator) -> None:
        self._schedule = schedule
        self._rng = rng
        self._channels: dict[Active, Channel] = {}
        self._frozen: Report | None = None
        self._last_setpoint: Message | None = None

    def told(self, state: Report) -> Report:
        """The state that the vehicle tells in place of its own."""
        active = self._schedule.active
        if not active:
            self._frozen = None
            return state
        if not _is_there(active, kinds.TelemetryFrozen):
            self._frozen = None
        else:
            self._frozen = frozen = self._frozen or state
            state = replace(frozen, firmware=state.firmware, system_id=state.system_id, time_s=state.time_s)
        step_s = sum(each.fault.step_s for each in active if isinstance(each.fault, kinds.ClockJump))
        return replace(state, time_s=max(0.0, state.time_s + step_s)) if step_s else state

    def withholds(self, message: Message) -> bool:
        """Whether the vehicle does not send a message that is due."""
        return any(
            isinstance(each.fault, kinds.MessageLost) and each.fault.message == message.get_type()
            for each in self._schedule.active
        )

    def heard(self, message: Message) -> Message:
        """What the autopilot makes of a message to it: a setpoint that it ignores is the one before."""
        if message.get_msgId() not in _SETPOINTS:
            return message
        if self._last_setpoint is None or not _is_there(self._schedule.active, kinds.SetpointsIgnored):
            self._last_setpoint = message
        return self._last_setpoint

    def way_out(self, arrivals_s: Sequence[float], frame: bytes) -> list[tuple[float, bytes]]:
        """When a frame of the vehicle arrives (s), and as which bytes."""
        for channel in self._ways(_TELEMETRY):
            arrivals_s = [later_s for at_s in arrivals_s for later_s in channel.arrivals_s(at_s)]
        return [(at_s, self._damaged(frame)) for at_s in arrivals_s]

    def way_in(self, arrivals_s: Sequence[float]) -> Sequence[float]:
        """When a frame to the vehicle arrives (s)."""
        for channel in self._ways(_UPLINK):
            arrivals_s = [later_s for at_s in arrivals_s for later_s in channel.arrivals_s(at_s)]
        return arrivals_s

    def _ways(self, concerned: tuple[type[kinds.Fault], ...]) -> Iterable[Channel]:
        """The channels that the faults there are put in the way, one behind the other."""
        for each in self._schedule.active:
            if isinstance(each.fault, concerned):
                if each not in self._channels:
                    self._channels[each] = _channel(each.fault, self._rng.spawn(1)[0])
                yield self._channels[each]

    def _damaged(self, frame: bytes) -> bytes:
        for each in self._schedule.active:
            if isinstance(each.fault, kinds.TelemetryCorrupted) and self._rng.random() < each.fault.share:
                wrong = bytearray(frame)
                for place in self._rng.integers(len(frame), size=_WRONG_BYTES):
                    wrong[place] ^= int(self._rng.integers(1, 256))
                frame = bytes(wrong)
        return frame


_TELEMETRY = (
    kinds.LinkLost,
    kinds.TelemetryLost,
    kinds.TelemetryLate,
    kinds.TelemetryLossy,
    kinds.TelemetryDuplicated,
    kinds.TelemetryReordered,
)
_UPLINK = (kinds.LinkLost, kinds.UplinkLost, kinds.UplinkLate, kinds.UplinkLossy)


def _channel(fault: kinds.Fault, rng: np.random.Generator) -> Channel:
    """The channel that a fault puts in the way of frames."""
    match fault:
        case (
            kinds.TelemetryLate(delay_s=delay, jitter_s=jitter)
            | kinds.UplinkLate(delay_s=delay, jitter_s=jitter)
        ):
            return Channel(delay, jitter, 0.0, rng)
        case kinds.TelemetryLossy(share=share) | kinds.UplinkLossy(share=share):
            return Channel(0.0, 0.0, share, rng)
        case kinds.TelemetryDuplicated(share=share):
            return Channel(0.0, 0.0, 0.0, rng, duplicates=share)
        case kinds.TelemetryReordered(share=share):
            return Channel(0.0, 0.0, 0.0, rng, overtaken=share)
    return Channel(0.0, 0.0, 1.0, rng)


def _is_there(active: Iterable[Active], kind: type[kinds.Fault]) -> bool:
    return any(isinstance(each.fault, kind) for each in active)

"""What others on the link ask of us, and the short answers that keep them from waiting.

A ground station that asks every component for its version, parameters and mission is soon done with those
that say that they have none. Nothing here changes what we do: whoever asks, nobody steers us.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeAlias

from companion.link.dialect import Message, mavlink

_Answer: TypeAlias = Callable[[Any, tuple[int, int]], Iterator[Message]]

_CAPABILITIES = mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2 | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
_BY_NUMBER = -1


def answers(question: Message, ids: tuple[int, int]) -> Iterator[Message]:
    """Our answers to a message of one of `QUESTIONS`; none unless it is addressed to us.

    Args:
        question: whoever sent it.
        ids: our system and component id.
    """
    asker = (question.get_srcSystem(), question.get_srcComponent())
    target = (getattr(question, "target_system", 0), getattr(question, "target_component", 0))
    wanted = (0, 0) if isinstance(question, mavlink.MAVLink_ping_message) else ids
    if target == wanted and asker != ids:
        yield from _ANSWERS[question.get_msgId()](question, asker)


def _to_ping(ping: Any, asker: tuple[int, int]) -> Iterator[Message]:
    yield mavlink.MAVLink_ping_message(ping.time_usec, ping.seq, *asker)


def _to_command(command: Any, asker: tuple[int, int]) -> Iterator[Message]:
    asks_version = command.command == mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES or (
        command.command == mavlink.MAV_CMD_REQUEST_MESSAGE
        and command.param1 == mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION
    )
    result = mavlink.MAV_RESULT_ACCEPTED if asks_version else mavlink.MAV_RESULT_UNSUPPORTED
    yield mavlink.MAVLink_command_ack_message(
        command.command, result, target_system=asker[0], target_component=asker[1]
    )
    if asks_version:
        none = [0] * 8
        yield mavlink.MAVLink_autopilot_version_message(_CAPABILITIES, 0, 0, 0, 0, none, none, none, 0, 0, 0)


def _to_parameter(request: Any, asker: tuple[int, int]) -> Iterator[Message]:
    name = getattr(request, "param_id", "").encode("ascii", "replace")
    index = getattr(request, "param_index", _BY_NUMBER)
    yield mavlink.MAVLink_param_error_message(*asker, name, index, mavlink.MAV_PARAM_ERROR_DOES_NOT_EXIST)


def _to_mission(request: Any, asker: tuple[int, int]) -> Iterator[Message]:
    yield mavlink.MAVLink_mission_ack_message(*asker, mavlink.MAV_MISSION_UNSUPPORTED, request.mission_type)


_ANSWERS: Mapping[int, _Answer] = {
    mavlink.MAVLINK_MSG_ID_PING: _to_ping,
    mavlink.MAVLINK_MSG_ID_COMMAND_LONG: _to_command,
    mavlink.MAVLINK_MSG_ID_COMMAND_INT: _to_command,
    mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_LIST: _to_parameter,
    mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_READ: _to_parameter,
    mavlink.MAVLINK_MSG_ID_PARAM_SET: _to_parameter,
    mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_LIST: _to_mission,
}

QUESTIONS = frozenset(_ANSWERS)
"""Ids of the messages that are looked at, whoever sends them; no MISSION_COUNT, which answers us as well."""

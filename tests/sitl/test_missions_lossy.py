"""A plain mission client against the vehicle, over a link that loses, doubles, delays and reorders frames."""

import heapq
from collections.abc import Iterable
from typing import Any, Literal

import pytest
from mavlink_fakes import encode
from plan_items import HOME, item
from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink import MavlinkVehicle, open_vehicle
from sitl.plan.items import Item

_RETRY_S = 0.5
ITEMS = (HOME, *(item(mavlink.MAV_CMD_NAV_WAYPOINT, float(n), -2.0 * n, 10.0 + n) for n in range(1, 200)))


class Client:
    """Sends, waits for an answer in virtual time, and sends again."""

    def __init__(self, vehicle: MavlinkVehicle) -> None:
        self._vehicle = vehicle
        self._arriving: list[tuple[float, int, bytes]] = []
        self._count = 0
        self._parser = mavlink.MAVLink(None)

    def ask(self, question: Any, wanted: Iterable[str]) -> Any:
        for _ in range(20):
            self._vehicle.receive(encode(question))
            until_s = self._vehicle.simulation.time_s + _RETRY_S
            while (now_s := self._vehicle.simulation.time_s) < until_s - 1e-6:
                for delivery in self._vehicle.advance(now_s + 0.01):
                    self._count += 1
                    heapq.heappush(self._arriving, (delivery.time_s, self._count, delivery.data))
                while self._arriving and self._arriving[0][0] <= now_s:
                    for message in self._parser.parse_buffer(heapq.heappop(self._arriving)[2]) or []:
                        if message.get_type() in wanted and self._answers(question, message):
                            return message
        raise AssertionError(f"no answer to {question}")

    @staticmethod
    def _answers(question: Any, message: Any) -> bool:
        """Whether it is no duplicate of what came before."""
        last = question.seq if hasattr(question, "seq") else -1
        if message.get_type() == "MISSION_ITEM_INT":
            return bool(message.seq == last)
        return not hasattr(message, "seq") or bool(message.seq > last)

    def upload(self, items: tuple[Item, ...]) -> int:
        asked: Any = mavlink.MAVLink_mission_count_message(1, 1, len(items))
        wanted = ("MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK")
        while (answer := self.ask(asked, wanted)).get_type() != "MISSION_ACK":
            each = items[answer.seq]
            head = (1, 1, answer.seq, each.frame, each.command, 0, 1)
            fields = (*each.params, each.x, each.y, each.z)
            asked = mavlink.MAVLink_mission_item_int_message(*head, *fields)
        return int(answer.type)

    def download(self) -> list[tuple[int, int, int, float]]:
        count = self.ask(mavlink.MAVLink_mission_request_list_message(1, 1), ("MISSION_COUNT",)).count
        items = []
        for seq in range(count):
            request = mavlink.MAVLink_mission_request_int_message(1, 1, seq)
            got = self.ask(request, ("MISSION_ITEM_INT",))
            items.append((got.command, got.x, got.y, got.z))
        return items


@pytest.mark.parametrize("autopilot", ["px4", "ardupilot"])
def test_two_hundred_items_go_up_and_down_a_bad_link(autopilot: Literal["px4", "ardupilot"]) -> None:
    client = Client(open_vehicle("bebop2", "lossy", seed=3, autopilot=autopilot))
    assert client.upload(ITEMS) == mavlink.MAV_MISSION_ACCEPTED
    downloaded = client.download()
    first = 1 if autopilot == "ardupilot" else 0  # ArduPilot has home there
    assert downloaded[first:] == [(each.command, each.x, each.y, each.z) for each in ITEMS[first:]]

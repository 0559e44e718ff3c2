"""A link through pymavlink's mavutil, read by a thread of its own."""

import os
import threading
import time
from collections.abc import Sequence
from queue import Empty, Queue
from typing import Any

os.environ["MAVLINK20"] = "1"  # read when mavutil is imported

from peer_server import PATIENCE_S, wait_until
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

_AUTOPILOTS = {mavlink.MAV_AUTOPILOT_PX4: "px4", mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: "ardupilot"}


class MavutilLink:
    """Keeps the newest message of each type that the vehicle sent; passes on those that answer something."""

    def __init__(self, url: str) -> None:
        self.connection = mavutil.mavlink_connection(url)
        if self.connection.wait_heartbeat(timeout=PATIENCE_S) is None:
            raise TimeoutError("no heartbeat")
        self._newest: dict[str, Any] = {}
        self._answers: Queue[Any] = Queue()
        self._texts: list[str] = []
        self.received_parameters: dict[str, Any] = {}
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        while True:
            message = self.connection.recv_match(blocking=True, timeout=1.0)
            if message is None or message.get_srcSystem() != self.connection.target_system:
                continue
            kind = message.get_type()
            self._newest[kind] = message
            if kind == "STATUSTEXT":
                self._texts.append(message.text)
            elif kind == "PARAM_VALUE" and message.param_id != "_HASH_CHECK":  # PX4's; not one of them
                self.received_parameters[message.param_id] = message
            elif kind == "COMMAND_ACK" or kind.startswith("MISSION_"):
                self._answers.put(message)

    def has(self, kind: str) -> bool:
        return kind in self._newest

    def newest(self, kind: str) -> Any:
        wait_until(lambda: kind in self._newest, f"a {kind}")
        return self._newest[kind]

    def forget_answers(self) -> None:
        while not self._answers.empty():
            self._answers.get()

    def answer(self, *kinds: str, timeout_s: float = PATIENCE_S) -> Any:
        """The next message of these types; None when none came in time."""
        give_up_s = time.monotonic() + timeout_s  # for all of them: some types stream
        while (left_s := give_up_s - time.monotonic()) > 0.0:
            try:
                message = self._answers.get(timeout=left_s)
            except Empty:
                break
            if message.get_type() in kinds:
                return message
        return None

    def autopilot(self) -> str:
        return _AUTOPILOTS[self.newest("HEARTBEAT").autopilot]

    def system_id(self) -> int:
        return int(self.newest("HEARTBEAT").get_srcSystem())

    def texts(self) -> list[str]:
        return self._texts

    def mode(self) -> str:
        return str(self.connection.flightmode)

    def armed(self) -> bool:
        return bool(self.newest("HEARTBEAT").base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)

    def place(self) -> Sequence[float]:
        position = self.newest("GLOBAL_POSITION_INT")
        return position.lat * 1e-7, position.lon * 1e-7, position.relative_alt * 1e-3

    def home(self) -> Sequence[float]:
        home = self.newest("HOME_POSITION")
        return home.latitude * 1e-7, home.longitude * 1e-7, home.altitude * 1e-3

"""MAVProxy without a screen: commands on its standard input, telemetry from the copy that it passes on."""

import re
import socket
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

from mavutil_link import MavutilLink
from peer_client import Place
from peer_server import serve, wait_until
from pymavlink import mavutil, mavwp
from pymavlink.dialects.v20 import common as mavlink

_PROGRAM = Path(__file__).parents[2] / ".venv-peers/mavproxy/bin"
_MODULES = "log,wp,rally,fence,param,arm,mode,misc,cmdlong,output"


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


class MavproxyClient:
    def __init__(self, port: int) -> None:
        self._folder = Path.cwd()
        out = _free_port()
        self._process = subprocess.Popen(
            [
                _PROGRAM / "python",
                _PROGRAM / "mavproxy.py",
                f"--master=udpin:127.0.0.1:{port}",
                f"--out=udpout:127.0.0.1:{out}",
                f"--state-basedir={self._folder}",
                f"--logfile={self._folder / 'flight.tlog'}",
                f"--default-modules={_MODULES}",
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self._output = ""
        threading.Thread(target=self._read, daemon=True).start()
        self._link = MavutilLink(f"udpin:127.0.0.1:{out}")
        self._autopilot = self._link.autopilot()
        self._wait_said(r"Received \d+ parameters")
        self._type("set streamrate 10")  # asks at once; on its own it asks every 15 s

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._output += line

    def _type(self, line: str) -> None:
        """Type a command; what was said before is forgotten."""
        assert self._process.stdin is not None
        self._output = ""
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def _wait_said(self, pattern: str) -> re.Match[str]:
        wait_until(lambda: re.search(pattern, self._output), f"{pattern!r} in {self._output!r}")
        found = re.search(pattern, self._output)
        assert found is not None
        return found

    def autopilot(self) -> str:
        return self._link.autopilot()

    def system_id(self) -> int:
        return self._link.system_id()

    def mode(self) -> str:
        return self._link.mode()

    def set_mode(self, name: str) -> None:
        self._type(f"mode {name}")
        wait_until(lambda: self.mode() == name, f"mode {name}")

    def arm(self) -> None:
        if self._autopilot == "ardupilot":  # after a landing it is in LAND
            self.set_mode("GUIDED")
        self._type("arm throttle")
        wait_until(self.armed, "armed")

    def disarm(self) -> None:
        self._type("disarm")

    def armed(self) -> bool:
        return self._link.armed()

    def take_off(self, height_m: float) -> None:
        if self._autopilot == "px4":
            self._type(f"long NAV_TAKEOFF 0 0 0 nan nan nan {self.home()[2] + height_m}")
        else:
            self._type(f"takeoff {height_m}")

    def place(self) -> Place:
        return self._link.place()

    def go_to(self, place: Place) -> None:
        self._type("guided {} {} {}".format(*place))

    def return_home(self) -> None:
        self._type("long NAV_RETURN_TO_LAUNCH")

    def land(self) -> None:
        self._type("long NAV_LAND 0 0 0 nan")

    def texts(self) -> list[str]:
        return re.findall(r"AP: (.*)", self._output)

    def parameters(self) -> dict[str, float]:
        self._type("param fetch")
        self._wait_said(r"Received \d+ parameters")
        self._type(f"param save {self._folder / 'all.parm'}")
        self._wait_said(r"Saved \d+ parameters")
        lines = (self._folder / "all.parm").read_text().splitlines()
        return {name: float(value) for name, value in (line.split()[:2] for line in lines)}

    def parameter(self, name: str) -> float:
        self._type(f"param fetch {name}")
        return float(self._wait_said(rf"{name} = (\S+)")[1])

    def set_parameter(self, name: str, value: float) -> None:
        self._type(f"param set {name} {value}")

    def home(self) -> Place:
        return self._link.home()

    def upload(self, waypoints: Sequence[Place]) -> None:
        home = [(*self.home()[:2], 0.0)] if self._autopilot == "ardupilot" else []
        self._load("wp", [*home, *waypoints], mavlink.MAV_CMD_NAV_WAYPOINT)

    def _load(self, module: str, places: Sequence[Place], command: int, param1: float = 0.0) -> None:
        frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
        items = (
            [seq, int(seq == 0), frame, command, param1, 0, 0, 0, *place, 1]
            for seq, place in enumerate(places)
        )
        path = self._folder / f"{module}.txt"
        path.write_text("QGC WPL 110\n" + "".join("\t".join(map(str, item)) + "\n" for item in items))
        self._load_file(module, path)

    def _load_file(self, module: str, path: Path) -> None:
        self._type(f"{module} load {path}")
        self._wait_said(r"Sent all|Got MISSION_ACK: .*ACCEPTED")

    def _save(self, module: str, loader: mavwp.MissionItemProtocol) -> list[Place]:
        path = self._folder / f"{module}-saved.txt"
        self._type(f"{module} save {path}")
        if self._wait_said(r"Saved \d+|Requesting 0 ")[0].startswith("Requesting"):
            return []  # there is nothing to save
        loader.load(str(path))
        return [(item.x, item.y, item.z) for item in loader.wpoints]

    def download(self) -> list[Place]:
        return self._save("wp", mavwp.MAVWPLoader())[self._autopilot == "ardupilot" :]

    def start_mission(self) -> None:
        self._type("wp set 0" if self._autopilot == "px4" else "wp set 1")
        self._type("long MISSION_START")

    def items_done(self) -> int:
        return int(self._link.newest("MISSION_ITEM_REACHED").seq) + (self._autopilot == "px4")

    def clear_mission(self) -> None:
        self._type("wp clear")

    def upload_file(self, path: str) -> None:
        self._load_file("wp", Path(path))

    def upload_fence(self, corners: Sequence[Place]) -> None:
        corner = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
        self._load("fence", corners, corner, len(corners))

    def download_fence(self) -> list[Place]:
        return self._save("fence", mavwp.MissionItemProtocol_Fence())

    def clear_fence(self) -> None:
        self._type("fence clear")

    def upload_rally_points(self, places: Sequence[Place]) -> None:
        self._load("rally", places, mavlink.MAV_CMD_NAV_RALLY_POINT)

    def download_rally_points(self) -> list[Place]:
        return self._save("rally", mavwp.MissionItemProtocol_Rally())

    def logged(self) -> list[str]:
        """The types of the messages in the log of the link so far."""
        log = mavutil.mavlink_connection(str(self._folder / "flight.tlog"))
        kinds = set()
        while message := log.recv_match():
            kinds.add(message.get_type())
        return sorted(kinds)


if __name__ == "__main__":
    serve(MavproxyClient(int(sys.argv[1])))

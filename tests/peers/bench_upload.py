"""How long a mission of 1,000 items takes from a client with pymavlink to the simulated vehicle, over UDP.

Usage: scripts/bench-upload
"""

import tempfile
import time
from pathlib import Path

from mavutil_link import MavutilLink
from mavutil_missions import download, upload, waypoint
from peering import free_system_id, port_of, vehicle
from pymavlink.dialects.v20 import common as mavlink

ITEMS = 1000


def main() -> None:
    for autopilot in ("px4", "ardupilot"):
        system_id = free_system_id(autopilot)
        with tempfile.TemporaryDirectory() as folder, vehicle(autopilot, system_id, Path(folder), speed=1):
            link = MavutilLink(f"udpin:127.0.0.1:{port_of(autopilot, system_id)}")
            place = (47.3977, 8.5456, 10.0)
            items = [waypoint(link, place, mavlink.MAV_CMD_NAV_WAYPOINT, 0) for _ in range(ITEMS)]
            start_s = time.perf_counter()
            upload(link, items, 0)
            up_s = time.perf_counter()
            assert len(download(link, 0)) == ITEMS
            down_s = time.perf_counter()
        print(f"{autopilot}: {ITEMS} items up in {up_s - start_s:.2f} s, down in {down_s - up_s:.2f} s")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Inspect a mast: circle it at three heights, looking at it, and return.

scripts/examples/inspection_orbit.py --connect udpin://0.0.0.0:14540
"""

import argparse

from companion.mission import Drone, Mission, run

MAST = (15.0, 5.0)
"""Metres north and east of home."""


async def inspect(drone: Drone) -> None:
    """Circle the mast 6 m away, at 4, 6 and 8 m."""
    mission = Mission().takeoff(4).speed(3)
    for altitude_m in (4, 6, 8):
        mission = mission.orbit(MAST, 6, altitude_m)
    await drone.upload(mission.return_home())
    async for reached in drone.fly():
        print(f"{reached.index + 1}/{reached.total} {reached.item.name}")
    print("back home")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Circle a mast at three heights.")
    parser.add_argument("--connect", metavar="URL", default="sitl://bebop2")
    run(inspect, parser.parse_args().connect)

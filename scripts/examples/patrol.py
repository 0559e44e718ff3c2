#!/usr/bin/env python3
"""Patrol a square for ever, and return when the battery is low.

scripts/examples/patrol.py --return-at 0.3 --connect udpin://0.0.0.0:14540
"""

import argparse
from functools import partial

from companion.mission import Drone, Mission, run


async def patrol(return_at: float, drone: Drone) -> None:
    """Fly along a square of 10 m until less than `return_at` (0 to 1) of the charge is left."""
    square = Mission().takeoff(5).go(10, 0, 5).go(10, 10, 5).go(0, 10, 5).go(0, 0, 5)
    await drone.upload(square.repeat(from_step=1, times=-1))
    async for reached in drone.fly():
        print(f"corner {reached.index}, battery {drone.battery:.0%}")
        if drone.battery <= return_at:
            print("battery low: returning")
            await drone.return_home()
            break
    print("back home")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Patrol a square until the battery is low.")
    parser.add_argument("--return-at", metavar="SHARE", type=float, default=0.3, help="charge left (0 to 1)")
    parser.add_argument("--connect", metavar="URL", default="sitl://bebop2")
    arguments = parser.parse_args()
    run(partial(patrol, arguments.return_at), arguments.connect)

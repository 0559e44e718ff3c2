#!/usr/bin/env python3
"""Upload a plan of QGroundControl with its fence and rally points, fly it, and see it through.

scripts/examples/upload_plan.py scripts/examples/field.plan --connect udpin://0.0.0.0:14540
"""

import argparse
from functools import partial
from pathlib import Path

from companion.mission import Drone, Plan, read_plan, run

FIELD = Path(__file__).with_name("field.plan")


async def fly(plan: Plan, drone: Drone) -> None:
    """Upload and fly `plan`; it ends as it says itself."""
    await drone.upload(plan)
    print(f"uploaded and verified: {len(plan.mission)} items")
    async for reached in drone.fly():
        print(f"{reached.index + 1}/{reached.total} {reached.item.name}")
    print("the mission is done")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Upload a plan, and fly it.")
    parser.add_argument("plan", nargs="?", type=Path, default=FIELD)
    parser.add_argument("--connect", metavar="URL", default="sitl://bebop2")
    arguments = parser.parse_args()
    run(partial(fly, read_plan(arguments.plan)), arguments.connect)

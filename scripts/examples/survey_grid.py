#!/usr/bin/env python3
"""Survey a rectangle in parallel lines, and land where the survey ends.

scripts/examples/survey_grid.py --connect udpin://0.0.0.0:14540
"""

import argparse

from companion.mission import Drone, Mission, run


async def survey(drone: Drone) -> None:
    """Fly over 20 m by 12 m north-east of home, 8 m high, in lines 4 m apart."""
    mission = Mission().takeoff(8).speed(4).survey((0, 0), (20, 12), 8, spacing_m=4)
    await drone.upload(mission)
    async for reached in drone.fly():
        north, east, up = drone.position
        print(
            f"{reached.index + 1}/{reached.total} {reached.item.name} at {north:.1f}, {east:.1f}, {up:.1f} m"
        )
    await drone.land()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Survey a rectangle in parallel lines.")
    parser.add_argument("--connect", metavar="URL", default="sitl://bebop2")
    run(survey, parser.parse_args().connect)

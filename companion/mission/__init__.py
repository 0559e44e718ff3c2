"""Missions: plan files, scripts for vehicles, what of a plan can be tracked, and places on the Earth."""

from companion.geodesy import Place
from companion.mission.builder import Mission
from companion.mission.files import read_plan, write_plan
from companion.mission.items import Fence, FenceCircle, FencePolygon, Frame, MissionItem, Plan
from companion.mission.progress import Reached
from companion.mission.vehicle import Drone, run, vehicle

__all__ = [
    "Drone",
    "Fence",
    "FenceCircle",
    "FencePolygon",
    "Frame",
    "Mission",
    "MissionItem",
    "Place",
    "Plan",
    "Reached",
    "read_plan",
    "run",
    "vehicle",
    "write_plan",
]

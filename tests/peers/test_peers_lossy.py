"""A client of another maker on a link that loses, doubles, delays and mixes up frames, in both directions."""

from pathlib import Path

import pytest
from peering import client, distance_m, free_system_id, moved, port_of, vehicle

pytestmark = pytest.mark.realtime

ITEMS = 50


@pytest.mark.parametrize("autopilot", ["px4", "ardupilot"])
def test_a_mission_over_a_lossy_link(autopilot: str, tmp_path: Path) -> None:
    system_id = free_system_id(autopilot)
    with (
        vehicle(autopilot, system_id, tmp_path, conditions="lossy"),
        client("pymavlink", port_of(autopilot, system_id), tmp_path) as peer,
    ):
        waypoints = [moved(peer.home(), north_m=float(number)) for number in range(ITEMS)]
        peer.upload(waypoints)
        received = peer.download()
    assert len(received) == ITEMS
    assert all(distance_m(one, other) < 0.1 for one, other in zip(received, waypoints, strict=True))

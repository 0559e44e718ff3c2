import random
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion import clock
from companion.doctor import Traffic
from companion.doctor.clocks import Trip, round_trips
from companion.doctor.observation import Loss, Peer
from companion.doctor.sequence import SequenceCount
from companion.doctor.silence import likely_causes
from companion.link.address import Address, parse_address
from companion.link.dialect import mavlink
from companion.link.framing import FrameCounts


def counted(numbers: list[int]) -> Loss:
    count = SequenceCount()
    for number in numbers:
        count.add(number % 256)
    return count.loss


@given(start=st.integers(0, 255), kept=st.lists(st.booleans(), min_size=1, max_size=600))
def test_each_lost_frame_is_counted(start: int, kept: list[bool]) -> None:
    arrived = [start + place for place, keep in enumerate(kept) if keep]
    gaps = [later - earlier for earlier, later in pairwise(arrived)]
    if arrived and max(gaps, default=1) < 128:
        lost = arrived[-1] - arrived[0] + 1 - len(arrived)
        assert counted(arrived) == Loss(frames=len(arrived), lost=lost)


def test_frames_that_come_twice_or_late_are_not_lost() -> None:
    assert counted([250, 251, 254, 253, 253, 255, 0, 2, 1]) == Loss(8, lost=1, duplicated=1, reordered=2)
    assert Loss(75, lost=25).share == 0.25
    assert Loss().share == 0.0


def test_round_trips_tell_delay_offset_and_drift() -> None:
    rng = random.Random(1)
    trips = []
    for place in range(100):
        asked = 50.0 + 0.1 * place
        there, back = 0.005 + 0.004 * rng.random(), 0.005 + 0.004 * rng.random()
        vehicle = (asked + there - 40.0) * (1 - 500e-6)  # ours runs ahead of it
        trips.append(Trip(asked, vehicle, asked + there + back))
    told = round_trips(100, trips)
    assert told is not None
    assert told.median_s == pytest.approx(0.014, abs=0.002)
    assert told.median_s < told.p95_s < 0.018
    assert told.offset_s == pytest.approx(40.0, abs=0.02)
    assert told.drift_ppm == pytest.approx(500.0, abs=60.0)


def test_a_drift_that_jitter_hides_is_not_told() -> None:
    rng = random.Random(1)
    asked_s = [0.1 * place for place in range(50)]
    trips = [Trip(asked, asked + 0.2 * rng.random(), asked + 0.2) for asked in asked_s]
    told = round_trips(50, trips)
    assert told is not None
    assert told.drift_ppm is None


def test_no_answer_is_no_figure() -> None:
    assert round_trips(100, []) is None
    only = round_trips(3, [Trip(1.0, 0.5, 1.1)])
    assert only is not None
    assert only.drift_ppm is None


def test_traffic_is_told_apart_by_sender() -> None:
    async def scenario() -> None:
        traffic = Traffic()
        senders = {ids: mavlink.MAVLink(None, *ids) for ids in ((1, 1), (1, 154), (2, 1))}
        for tick in range(101):
            await clock.sleep_until(traffic.began_s + 0.02 * tick)
            for ids, sender in senders.items():
                beat = mavlink.MAVLink_heartbeat_message(2, 12, 0, 0, 4, 3)
                if not (ids == (1, 1) and tick == 50):
                    traffic.add(bytes(beat.pack(sender)))
                sender.seq = (sender.seq + 1) % 256
        stream = traffic.streams(1, 1)["HEARTBEAT"]
        assert stream.rate_hz == pytest.approx(50.0)
        assert stream.longest_gap_s == pytest.approx(0.04)
        assert 0.001 < stream.jitter_s < 0.01
        assert traffic.losses == {(1, 1): Loss(100, lost=1), (1, 154): Loss(101), (2, 1): Loss(101)}
        assert set(traffic.peers) == set(senders)
        traffic.restart()
        assert traffic.streams(1, 1) == {}

    clock.run(scenario(), virtual=True)


AUTOPILOT = {(2, 1): Peer(2, 1, 2, mavlink.MAV_AUTOPILOT_PX4)}
STATION = {(255, 190): Peer(255, 190, 6, mavlink.MAV_AUTOPILOT_INVALID)}


@pytest.mark.parametrize(
    ("url", "peers", "counts", "told"),
    [
        ("udpin://0.0.0.0:14541", {}, FrameCounts(), "another port than 14541"),
        ("udpin://0.0.0.0:14541", {}, FrameCounts(), "another program"),
        ("udpout://10.0.0.1:14540", {}, FrameCounts(), "firewall"),
        ("tcpout://127.0.0.1:5762", {}, FrameCounts(), "another client"),
        ("tcpin://127.0.0.1:5762", {}, FrameCounts(), "no client"),
        ("serial:///dev/ttyS0:57600", {}, FrameCounts(), "TX and RX"),
        ("serial:///dev/ttyS0:57600", {}, FrameCounts(stray_bytes=9), "115200, 921600"),
        ("udpin://0.0.0.0:14541", {}, FrameCounts(stray_bytes=9), "something else"),
        ("udpin://0.0.0.0:14541", {}, FrameCounts(frames=9), "no heartbeat"),
        ("udpin://0.0.0.0:14541", AUTOPILOT, FrameCounts(frames=9), "systems 2; asked for 7"),
        ("udpin://0.0.0.0:14541", STATION, FrameCounts(frames=9), "system 255 component 190"),
        ("sitl://bebop2", {}, FrameCounts(), "another system id"),
    ],
)
def test_silence_has_likely_causes(
    url: str, peers: dict[tuple[int, int], Peer], counts: FrameCounts, told: str
) -> None:
    address: Address = parse_address(url)
    assert told in "; ".join(likely_causes(address, peers, counts, 7))

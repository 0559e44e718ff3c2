from collections import Counter

import pytest
from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink import GROUND_STATION, OFFBOARD
from sitl.mavlink.links import Link, Streams
from sitl.mavlink.px4 import PX4

ATTITUDE = mavlink.MAVLINK_MSG_ID_ATTITUDE
ALTITUDE = mavlink.MAVLINK_MSG_ID_ALTITUDE


def sent(streams: Streams, seconds: int, from_s: int = 0) -> Counter[int]:
    """How often each message was due within so many seconds of 10 ms ticks."""
    ticks = range(from_s * 100, (from_s + seconds) * 100)
    return Counter(message_id for tick in ticks for message_id in streams.take_due(tick * 10_000))


@pytest.mark.parametrize("link", [OFFBOARD, GROUND_STATION])
def test_every_stream_comes_at_its_rate(link: Link) -> None:
    counts = sent(Streams(link.rates_hz), 60)
    assert {message_id: count / 60 for message_id, count in counts.items()} == pytest.approx(
        dict(link.rates_hz), rel=0.001
    )


@pytest.mark.parametrize("link", [OFFBOARD, GROUND_STATION])
def test_every_stream_can_be_written(link: Link) -> None:
    assert set(link.rates_hz) <= set(PX4.writers)


def test_a_rate_above_the_tick_is_the_tick() -> None:
    assert sent(Streams({ATTITUDE: 400.0}), 2)[ATTITUDE] == 200


def test_a_stream_can_be_changed_stopped_and_set_back() -> None:
    streams = Streams({ATTITUDE: 50.0})
    streams.set_interval(ATTITUDE, 10_000, 0)
    assert sent(streams, 1)[ATTITUDE] == 100
    streams.set_interval(ATTITUDE, -1, 1_000_000)
    assert streams.interval_us(ATTITUDE) is None
    assert sent(streams, 1, from_s=1)[ATTITUDE] == 0
    streams.set_interval(ATTITUDE, 0, 2_000_000)
    assert sent(streams, 1, from_s=2)[ATTITUDE] == 50


def test_a_stream_that_the_link_lacks_can_be_added() -> None:
    streams = Streams({ATTITUDE: 10.0})
    streams.set_interval(ALTITUDE, 100_000, 0)
    assert sent(streams, 1) == {ATTITUDE: 10, ALTITUDE: 10}
    streams.set_interval(ALTITUDE, 0, 1_000_000)
    assert sent(streams, 1, from_s=1) == {ATTITUDE: 10}

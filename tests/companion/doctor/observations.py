"""What a healthy vehicle looks like, to be spoilt by tests."""

from dataclasses import fields, replace
from typing import Any

from companion.autopilot import Identity
from companion.doctor import Finding, Observation, judge
from companion.doctor.observation import Health, Loss, RoundTrips, Stream
from companion.link.estimator import Estimator

_STREAMS = {"LOCAL_POSITION_NED": Stream(98.0, 0.002, 0.03), "ATTITUDE": Stream(98.0, 0.002, 0.03)}
PX4 = Observation(
    system_id=1,
    identity=Identity("PX4", "1.16.1", takes_setpoints=True, uid="5"),
    vehicle_type="quadrotor",
    is_multirotor=True,
    mode="AUTO.LOITER",
    armed=False,
    seconds=10.0,
    streams=_STREAMS,
    losses={(1, 1): Loss(frames=3000)},
    round_trips=RoundTrips(100, 100, 0.002, 0.005, 12.0, 20.0),
    health=Health(
        estimator=Estimator(worst_ratio=0.2),
        has_position=True,
        has_home=True,
        gps_fix=3,
        satellites=10,
        ready_to_arm=True,
        has_remote_control=True,
        battery=0.9,
    ),
    parameters={"COM_OF_LOSS_T": 1.0, "COM_OBL_RC_ACT": 0},
)
ARDUPILOT = replace(
    PX4,
    identity=Identity("ArduPilot", "4.6.0", takes_setpoints=True),
    mode="STABILIZE",
    parameters={"GUID_TIMEOUT": 3.0, "ARMING_CHECK": 1},
)


def found(seen: Observation, topic: str, **changes: Any) -> Finding:
    """What is said of `topic` when `changes` are made to what was seen, or to its health."""
    of_health = {field.name for field in fields(Health)} & changes.keys()
    health = replace(seen.health, **{name: changes.pop(name) for name in of_health})
    (finding,) = (each for each in judge(replace(seen, health=health, **changes)) if each.topic == topic)
    return finding

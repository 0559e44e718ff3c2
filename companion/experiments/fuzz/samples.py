"""Files of every kind that are read, whole and right: what mutations begin with."""

import io
import struct
from collections.abc import Mapping, Sequence
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory

from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from companion import bundled
from companion.experiments.cut_recordings import record
from companion.experiments.simulated_flights import Scenario
from companion.flight.strategies import Strategy
from companion.geodesy import Place
from companion.link.dialect import mavlink
from companion.mission.files import write_plan
from companion.mission.items import Fence, FenceCircle, FencePolygon, Frame, MissionItem, Plan
from companion.trajectory import Limits, Placement, read_trajectory

_MCAP_BYTES = 150_000
_TLOG_BYTES = 60_000
_MESSAGES = 300
_ULOG_TOPICS = {
    "vehicle_local_position": [(name, "") for name in ("x", "y", "z", "vx", "vy", "vz")],
    "vehicle_attitude": [("q", "[4]")],
    "trajectory_setpoint": [("position", "[3]"), ("velocity", "[3]"), ("acceleration", "[3]"), ("yaw", "")],
    "vehicle_status": [("nav_state", "")],
}
"""Fields and how many numbers each has."""
_ULOG_STEPS = 50
_CSV = (
    b"t,n,e,d\n0,0,0,-2\n1,0.5,0,-2\n2,1,0.5,-2.5\n",
    b"t;x;y;z\n0;0,0;0;2\n1;0,5;0;2\n2;1;0,5;2,5\n",
    b"# a drawing\n0 0\n1 2\n3 1\n2 -1\n",
)
_PARAMETERS = (
    b"# Vehicle-Id Component-Id Name Value Type\n1\t1\tMPC_XY_P\t0.95\t9\n1\t1\tCOM_OBL_RC_ACT\t0\t6\n",
    b"WPNAV_ACCEL,250\nWPNAV_SPEED,500.0\nFENCE_ENABLE 0\n",
)
_FAULTS = b"""faults:
  - {kind: motor_weak, motor: 2, effectiveness: 0.6, after: takeoff, at_s: 12}
  - {kind: gust, north_m_s: 8.0, lasts_s: 2.0}
"""
_CARD = b"""{"vehicle": "bebop2", "system_id": 1, "hover": {"start_unix_s": 1.0, "end_unix_s": 2.0},
"segments": [{"id": "a", "start_unix_s": 1.5, "end_unix_s": 2.5, "rms_m": 0.1}]}"""
_KEYS = (b"00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff\n", b"a passphrase\n")


def samples() -> Mapping[str, Sequence[bytes]]:
    """The content of right files, by the reader that they are for (`companion.experiments.fuzz.files`)."""
    mcap, tlog = _flight()
    return {
        "csv": (*_shipped("trajectories", "*.csv"), *_CSV),
        "plan": (_plan(".plan"),),
        "waypoints": (_plan(".waypoints"),),
        "vehicle": _shipped("vehicles", "*.yaml"),
        "conditions": _shipped("conditions", "*.yaml"),
        "faults": (_FAULTS,),
        "guard": _shipped(".", "guard.yaml"),
        "model": _shipped("models", "ardrone2.safetensors"),
        "recording": (mcap[:_MCAP_BYTES], _plain(mcap)),
        "replay": (_plain(mcap),),
        "tlog": (tlog[:_TLOG_BYTES],),
        "card": (_CARD,),
        "ulog": (_ulog(),),
        "parameters": _PARAMETERS,
        "signing key": _KEYS,
    }


def _shipped(folder: str, names: str) -> tuple[bytes, ...]:
    return tuple(path.read_bytes() for path in sorted((bundled.config_directory() / folder).glob(names)))


def _flight() -> tuple[bytes, bytes]:
    """A flight's recording, and its link."""
    trajectory = read_trajectory(bundled.find("trajectories", "star", ".csv"), Placement(), Limits())
    with TemporaryDirectory() as folder:
        path = Path(folder) / "flight.mcap"
        record(Scenario(trajectory, Strategy.GP), path)
        return path.read_bytes(), path.with_suffix(".tlog").read_bytes()


def _plain(recording: bytes) -> bytes:
    """The first messages of a recording, not packed and without checksums: mutations reach their readers."""
    reader = make_reader(io.BytesIO(recording))
    output = io.BytesIO()
    writer = Writer(output, compression=CompressionType.NONE, enable_crcs=False)
    writer.start()
    for attachment in reader.iter_attachments():
        writer.add_attachment(0, 0, attachment.name, attachment.media_type, attachment.data)
    for metadata in reader.iter_metadata():
        writer.add_metadata(metadata.name, metadata.metadata)
    channels: dict[str, int] = {}
    for schema, channel, message in islice(reader.iter_messages(), _MESSAGES):
        assert schema is not None, "every topic of ours has one"
        if channel.topic not in channels:
            schema_id = writer.register_schema(schema.name, schema.encoding, b"{}")
            channels[channel.topic] = writer.register_channel(channel.topic, "json", schema_id)
        writer.add_message(channels[channel.topic], message.log_time, message.data, message.publish_time)
    writer.finish()  # type: ignore[no-untyped-call]
    return output.getvalue()


def _plan(suffix: str) -> bytes:
    corners = [(47.397, 8.545), (47.398, 8.545), (47.398, 8.546), (47.397, 8.546)]
    waypoints = [
        MissionItem(mavlink.MAV_CMD_NAV_WAYPOINT, Frame.ABOVE_HOME, x=north, y=east, z=20.0)
        for north, east in corners
    ]
    jump = MissionItem(mavlink.MAV_CMD_DO_JUMP, params=(1.0, 2.0, 0.0, 0.0))
    fence = Fence((FencePolygon(tuple(corners)),), (FenceCircle(47.3975, 8.5455, 200.0),))
    home = Place(47.397, 8.545, 488.0)
    plan = (
        Plan((*waypoints, jump), fence, (home,), home)
        if suffix == ".plan"
        else Plan((*waypoints, jump), home=home)
    )
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"sample{suffix}"
        write_plan(plan, path)
        return path.read_bytes()


def _ulog() -> bytes:
    """A second of PX4's log: https://docs.px4.io/main/en/dev_log/ulog_file_format.html."""
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0), _ulog_message(b"B", bytes(40))]
    for topic, fields in _ULOG_TOPICS.items():
        format_ = f"{topic}:uint64_t timestamp;" + "".join(f"float{count} {name};" for name, count in fields)
        parts.append(_ulog_message(b"F", format_.encode()))
    for number, topic in enumerate(_ULOG_TOPICS):
        parts.append(_ulog_message(b"A", struct.pack("<BH", 0, number) + topic.encode()))
    for step in range(_ULOG_STEPS):
        for number, fields in enumerate(_ULOG_TOPICS.values()):
            width = sum(int(count.strip("[]") or 1) for _, count in fields)
            row = struct.pack(f"<HQ{width}f", number, step * 20_000, *([1.0] * width))
            parts.append(_ulog_message(b"D", row))
    return b"".join(parts)


def _ulog_message(kind: bytes, body: bytes) -> bytes:
    return struct.pack("<Hc", len(body), kind) + body

"""What was seen of a vehicle and its link, before anything is made of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from companion.autopilot import Identity
from companion.link.estimator import Estimator
from companion.link.parameter_encoding import Number


@dataclass(frozen=True, slots=True)
class Stream:
    """How one message of the vehicle came.

    Attributes:
        rate_hz: mean rate (Hz).
        jitter_s: standard deviation of the time between two (s).
        longest_gap_s: longest time between two (s).
    """

    rate_hz: float
    jitter_s: float
    longest_gap_s: float


@dataclass(frozen=True, slots=True)
class Loss:
    """What arrived of one component's frames, by their sequence numbers.

    Attributes:
        frames: how many arrived.
        lost: how many did not.
        duplicated: how many arrived again.
        reordered: how many arrived after later ones.
    """

    frames: int = 0
    lost: int = 0
    duplicated: int = 0
    reordered: int = 0

    @property
    def share(self) -> float:
        """Lost, of all that were sent (0 to 1)."""
        return self.lost / max(self.lost + self.frames, 1)


@dataclass(frozen=True, slots=True)
class RoundTrips:
    """Of TIMESYNC questions and answers.

    Attributes:
        asked: questions sent.
        answered: answers that came.
        median_s: round-trip time (s).
        p95_s: 95th percentile of it (s).
        offset_s: companion clock minus vehicle clock (s), at the last answer.
        drift_ppm: how much faster the companion's clock runs (parts per million); None if that is not known.
    """

    asked: int
    answered: int
    median_s: float
    p95_s: float
    offset_s: float
    drift_ppm: float | None


@dataclass(frozen=True, slots=True)
class Peer:
    """Who else heartbeats on the link: MAV_TYPE and MAV_AUTOPILOT are MAVLink's numbers."""

    system_id: int
    component_id: int
    type: int
    autopilot: int


@dataclass(frozen=True, slots=True)
class Health:
    """What a vehicle tells of itself; None stands for what it does not tell.

    Attributes:
        estimator: its own account of where it is.
        has_position: whether a finite LOCAL_POSITION_NED came.
        has_home: whether HOME_POSITION came.
        gps_fix: GPS_FIX_TYPE; 3 is a fix in three dimensions.
        satellites: in the fix.
        ready_to_arm: whether the autopilot's checks before arming pass.
        has_remote_control: whether a remote control is received.
        battery: remaining charge (0 to 1).
    """

    estimator: Estimator | None = None
    has_position: bool = False
    has_home: bool = False
    gps_fix: int | None = None
    satellites: int | None = None
    ready_to_arm: bool | None = None
    has_remote_control: bool = False
    battery: float | None = None


@dataclass(frozen=True, slots=True)
class Observation:
    """A vehicle and the link to it, over `seconds`.

    Attributes:
        system_id: MAVLink id of the vehicle.
        identity: its autopilot.
        vehicle_type: MAV_TYPE in words.
        is_multirotor: whether that is one.
        mode: flight mode, by the autopilot's name.
        armed: whether the motors may turn.
        seconds: how long was measured (s).
        waited_s: how long was waited for the vehicle to be ready, before that (s).
        streams: the autopilot's messages by name.
        losses: by system and component id.
        stray_bytes: bytes that belonged to no valid frame.
        bad_checksums: frames that were spoilt.
        round_trips: of TIMESYNC.
        peers: who else is there.
        health: what it tells of itself.
        complaints: what it said in words that was a warning or worse.
        parameters: those that matter, and that the vehicle has.
        vehicle_signs: whether the vehicle signs its frames.
        we_sign: whether we sign ours.
        chosen: whether the user named this vehicle, or it was the first that was heard.
    """

    system_id: int
    identity: Identity
    vehicle_type: str
    is_multirotor: bool
    mode: str
    armed: bool
    seconds: float
    waited_s: float = 0.0
    streams: Mapping[str, Stream] = field(default_factory=dict)
    losses: Mapping[tuple[int, int], Loss] = field(default_factory=dict)
    stray_bytes: int = 0
    bad_checksums: int = 0
    round_trips: RoundTrips | None = None
    peers: tuple[Peer, ...] = ()
    health: Health = field(default_factory=Health)
    complaints: tuple[str, ...] = ()
    parameters: Mapping[str, Number] = field(default_factory=dict)
    vehicle_signs: bool = False
    we_sign: bool = False
    chosen: bool = False

    @property
    def version(self) -> tuple[int, ...] | None:
        """Of the autopilot, to be compared."""
        told = self.identity.version
        return None if told is None else tuple(int(part) for part in told.split("."))

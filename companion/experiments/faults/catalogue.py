"""What is let fail in the benchmark, and the written criterion of what can be survived."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from companion.experiments.faults.sabotage import Sabotage
from companion.flight.watchdogs import Watchdogs
from sitl.faults import kinds
from sitl.faults.reading import parse_fault
from sitl.vehicle import GRAVITY_M_S2, Vehicle

THRUST_MARGIN = 1.15
"""A weak rotor is survived that still lifts its share of the weight and this much of it to steer with."""
STRONGEST_GUST_M_S = 12.0
WIND_MARGIN = 0.8
"""A gust is survived up to this share of the wind that the vehicle holds against: there is wind besides."""
WIDEST_COMPASS_ERROR_DEG = 60.0
FENCE_MARGIN_M = 5.0
NOTICED_AFTER_S, HIGHEST_M = 2.5, 3.5
"""From a drift beyond the watchdog's limit to a landing at full speed, and from where that leads down."""
CRASH_M_S = 2.0
"""A touch-down faster than this breaks something."""


@dataclass(frozen=True, slots=True)
class Failure:
    """One fault with its parameters.

    Attributes:
        name: as in tables: kind and parameters.
        kind: alone.
        fault: of the vehicle or its link, as `sitl.faults.reading` reads it; empty for none.
        sabotage, amount: of the companion; None for none.
    """

    name: str
    kind: str
    fault: str = ""
    sabotage: Sabotage | None = None
    amount: float = 0.0


def of_vehicle(text: str) -> Failure:
    """A fault of the vehicle or its link."""
    return Failure(text, parse_fault(text).kind, fault=text)


def of_companion(what: Sabotage, amount: float = 0.0) -> Failure:
    """A fault of the companion."""
    return Failure(f"{what}:{amount:g}" if amount else str(what), str(what), sabotage=what, amount=amount)


VEHICLE_FAULTS = (
    "motor_weak:motor=1,effectiveness=0.9",
    "motor_weak:motor=2,effectiveness=0.7",
    "motor_weak:motor=3,effectiveness=0.4",
    "motor_dead:motor=4",
    "rotors_stopped",
    "gust:north_m_s=5,lasts_s=2",
    "gust:north_m_s=6,east_m_s=8,lasts_s=3",
    "gust:down_m_s=4,lasts_s=2",
    "battery_collapse:remaining=0.12",
    "battery_collapse:remaining=0.04",
    "battery_collapse:remaining=0",
    "gps_lost",
    "gps_lost:east_m_s2=0.2,lasts_s=3",
    "estimator_jump:north_m=1",
    "estimator_jump:north_m=1,announced=false",
    "estimator_jump:east_m=2",
    "estimator_jump:east_m=3.5",
    "estimator_jump:east_m=6",
    "estimator_drift:north_m_s=0.1",
    "estimator_drift:east_m_s=0.3",
    "estimator_drift:east_m_s=0.8",
    "velocity_error:north_m_s=0.3",
    "velocity_error:north_m_s=1",
    "compass_error:error_deg=15",
    "compass_error:error_deg=45",
    "compass_error:error_deg=120",
    "reboot",
    "pilot_mode:mode=POSCTL",
    "pilot_mode:mode=HOLD",
    "pilot_mode:mode=LAND",
    "pilot_sticks:pitch=0.2,lasts_s=1.5",
    "setpoints_ignored",
    "telemetry_lost:lasts_s=0.3",
    "telemetry_lost",
    "telemetry_frozen:lasts_s=1",
    "telemetry_frozen",
    "telemetry_late:delay_s=0.2",
    "telemetry_late:delay_s=1,jitter_s=0.2",
    "telemetry_lossy:share=0.3",
    "telemetry_duplicated:share=0.5",
    "telemetry_reordered:share=0.5",
    "telemetry_corrupted:share=0.3",
    "telemetry_corrupted:share=0.95",
    "message_lost:message=HEARTBEAT",
    "message_lost:message=ATTITUDE",
    "message_lost:message=LOCAL_POSITION_NED",
    "clock_jump:step_s=5",
    "clock_jump:step_s=-5",
    "uplink_lost:lasts_s=0.5",
    "uplink_lost",
    "uplink_late:delay_s=0.3",
    "uplink_lossy:share=0.5",
    "link_lost",
)
COMPANION_FAULTS = (
    (Sabotage.LOOP_STALLED, 0.3),
    (Sabotage.LOOP_STALLED, 1.5),
    (Sabotage.INFERENCE_SLOW, 0.03),
    (Sabotage.INFERENCE_SLOW, 0.3),
    (Sabotage.MODEL_NAN, 0.0),
    (Sabotage.MODEL_WILD, 5.0),
    (Sabotage.MODEL_FROZEN, 0.0),
    (Sabotage.MODEL_RAISES, 0.0),
    (Sabotage.PROCESS_KILLED, 0.0),
    (Sabotage.SECOND_COMPANION, 3.0),
)


def catalogue() -> Iterator[Failure]:
    """All that is let fail, always in the same order."""
    yield from map(of_vehicle, VEHICLE_FAULTS)
    for what, amount in COMPANION_FAULTS:
        yield of_companion(what, amount)


def kinds_among(failures: Iterable[Failure]) -> list[str]:
    """The kinds of these, each once."""
    return list(dict.fromkeys(failure.kind for failure in failures))


@dataclass(frozen=True, slots=True)
class Criterion:
    """What can be survived, as written before the flight, and whether this can."""

    text: str
    survivable: bool


def criterion(failure: Failure, vehicle: Vehicle) -> Criterion:
    """What must hold for `vehicle` to survive a failure, and whether it does."""
    if not failure.fault:
        return Criterion("always: the autopilot flies on its own", survivable=True)
    match parse_fault(failure.fault):
        case kinds.MotorWeak(effectiveness=share):
            least = THRUST_MARGIN * vehicle.hover_thrust
            text = (
                f"the rotor keeps {THRUST_MARGIN:g} times its share of the weight: {least:.2f} of its thrust"
            )
            return Criterion(text, share >= least)
        case kinds.MotorDead():
            rotors = len(vehicle.rotors.layout)
            return Criterion("six rotors or more", rotors >= 6)
        case kinds.RotorsStopped() | kinds.Reboot():
            return Criterion("never: all rotors stand still", survivable=False)
        case kinds.Gust(north_m_s=north, east_m_s=east, down_m_s=down):
            strength = (north**2 + east**2 + down**2) ** 0.5
            most = min(STRONGEST_GUST_M_S, WIND_MARGIN * held_wind_m_s(vehicle))
            text = f"up to {most:.1f} m/s: its largest lean holds against that, and the wind besides"
            return Criterion(text, strength <= most)
        case kinds.CompassError(error_deg=error):
            text = f"up to {WIDEST_COMPASS_ERROR_DEG:g}°: beyond, position control pushes the wrong way"
            return Criterion(text, abs(error) <= WIDEST_COMPASS_ERROR_DEG)
        case kinds.EstimatorJump(north_m=north, east_m=east, down_m=down):
            size = (north**2 + east**2 + down**2) ** 0.5
            most = CRASH_M_S / position_gain_1_s(vehicle)
            text = f"up to {most:.1f} m: it follows at {CRASH_M_S:g} m/s at most, should the ground be near"
            return Criterion(text, size <= most)
        case kinds.EstimatorDrift(north_m_s=north, east_m_s=east, down_m_s=down):
            speed = (north**2 + east**2 + down**2) ** 0.5
            lasts_s = NOTICED_AFTER_S + HIGHEST_M / landing_speed_m_s(vehicle)
            most = (FENCE_MARGIN_M - Watchdogs().gps_apart_m.limit) / lasts_s
            text = f"up to {most:.2f} m/s: the fence's margin of 5 m lasts until the vehicle is down"
            return Criterion(text, speed <= most)
        case kinds.BatteryCollapse():
            least = (vehicle.battery.empty_voltage_v / vehicle.battery.full_voltage_v) ** 2
            text = f"an empty battery's thrust ({least:.0%} of the full one) carries the weight"
            return Criterion(text, least >= THRUST_MARGIN * vehicle.hover_thrust)
        case kinds.PilotMode() | kinds.PilotSticks():
            return Criterion("always: the pilot has the vehicle", survivable=True)
    return Criterion("always: rotors and attitude are sound", survivable=True)


def position_gain_1_s(vehicle: Vehicle) -> float:
    """How fast the vehicle goes sideways for each metre that it believes itself off (1/s)."""
    ardupilot = vehicle.firmware == "ardupilot"
    return vehicle.ardupilot_parameters.PSC_POSXY_P if ardupilot else vehicle.px4_parameters.MPC_XY_P


def landing_speed_m_s(vehicle: Vehicle) -> float:
    """How fast the vehicle comes down near the ground (m/s)."""
    if vehicle.firmware == "ardupilot":
        return 0.01 * vehicle.ardupilot_parameters.LAND_SPEED
    return vehicle.px4_parameters.MPC_LAND_SPEED


def held_wind_m_s(vehicle: Vehicle) -> float:
    """Air speed whose drag is as much as the vehicle holds against at its largest lean (m/s)."""
    px4, ardupilot = vehicle.px4_parameters, vehicle.ardupilot_parameters
    own_deg = ardupilot.PSC_ANGLE_MAX or 0.01 * ardupilot.ANGLE_MAX
    lean_deg = own_deg if vehicle.firmware == "ardupilot" else px4.MPC_TILTMAX_AIR
    holds = vehicle.mass_kg * GRAVITY_M_S2 * math.tan(math.radians(lean_deg))
    rotors = len(vehicle.rotors.layout) * vehicle.rotor_drag_n_s2_per_m * vehicle.hover_speed_rad_s
    linear = rotors + vehicle.body_drag.linear_n_s_per_m[0]
    quadratic = vehicle.body_drag.quadratic_n_s2_per_m2[0]
    slowing = linear + math.sqrt(linear**2 + 4.0 * quadratic * holds)
    return 2.0 * holds / slowing if slowing else math.inf

from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import BaseModel

from sitl.conditions import (
    BatteryConditions,
    Conditions,
    LinkConditions,
    OwnErrors,
    PayloadConditions,
    WindConditions,
    load_conditions,
)
from sitl.errors import ConfigError
from sitl.estimator_errors import AttitudeError, EstimatorErrors, PositionError, RatesError, VelocityError
from sitl.files import known_names
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.firmware.px4_tuning import tuned_parameters
from sitl.vehicle import BatteryPack, BodyDrag, RotorPlace, Rotors, Vehicle, load_vehicle

SCHEMA = Path(__file__).parents[2] / "docs" / "vehicle-schema.md"
MINIMAL = SCHEMA.read_text(encoding="utf-8").split("```yaml\n")[1].split("```")[0]


def write(folder: Path, text: str) -> Path:
    file = folder / "mine.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def edited(folder: Path, edit: dict[str, Any]) -> Path:
    data = yaml.safe_load(MINIMAL)
    for dotted, value in edit.items():
        *path, last = dotted.split(".")
        section = data
        for key in path:
            section = section.setdefault(key, {})
        section[last] = value
    return write(folder, yaml.safe_dump(data))


def test_vehicles_that_ship() -> None:
    names = known_names("vehicles")
    assert {"ardrone2", "bebop2", "x500", "crazyflie", "iris"} <= set(names)
    for name in names:
        vehicle = load_vehicle(name)
        assert vehicle.name == name
        Px4Parameters.model_validate(tuned_parameters(vehicle).model_dump())


def test_conditions_that_ship_have_the_stated_numbers() -> None:
    ideal, realistic, windy = map(load_conditions, ("ideal", "realistic", "windy"))
    assert ideal.wind.mean_speed_m_s == ideal.wind.w20_kn == ideal.link.telemetry_latency_s == 0.0
    assert ideal.estimator == EstimatorErrors()
    for conditions, mean, w20 in ((realistic, 2.0, 15.0), (windy, 5.0, 30.0)):
        estimator, link = conditions.estimator, conditions.link
        assert isinstance(estimator, EstimatorErrors)
        assert (conditions.wind.mean_speed_m_s, conditions.wind.w20_kn) == (mean, w20)
        assert (estimator.position.noise_m, estimator.position.correlation_time_s) == (0.01, 1.0)
        assert (estimator.velocity.noise_m_s, estimator.velocity.correlation_time_s) == (0.03, 0.2)
        assert (estimator.attitude.noise_deg, estimator.attitude.correlation_time_s) == (0.5, 0.2)
        assert (estimator.rates.noise_deg_s, estimator.rates.correlation_time_s) == (1.0, 0.0)
        assert (link.telemetry_latency_s, link.telemetry_jitter_s) == (0.02, 0.01)
        assert (link.telemetry_loss_fraction, link.setpoint_latency_s) == (0.01, 0.02)


def test_a_minimal_file_is_enough(tmp_path: Path) -> None:
    vehicle = load_vehicle(write(tmp_path, MINIMAL))
    assert vehicle.name == "mine"
    assert vehicle.hover_thrust == pytest.approx(0.5)
    assert vehicle.battery_charge_as == pytest.approx(900.0 * vehicle.hover_current_a)


def test_own_parameters_survive_the_tuning(tmp_path: Path) -> None:
    vehicle = load_vehicle(edited(tmp_path, {"px4_parameters": {"MC_ROLLRATE_P": 0.11, "MPC_XY_P": 1.1}}))
    tuned = tuned_parameters(vehicle)
    assert (tuned.MC_ROLLRATE_P, tuned.MPC_XY_P) == (0.11, 1.1)
    assert tuned.MC_PITCHRATE_P != Px4Parameters().MC_PITCHRATE_P


@pytest.mark.parametrize(
    ("edit", "key", "reason"),
    [
        ({"mass_kg": -1.0}, "mass_kg", "greater than"),
        ({"mass_kg": "heavy"}, "mass_kg", "number"),
        ({"mass_kg": float("nan")}, "mass_kg", "finite"),
        ({"mass": 1.0}, "mass", "unknown key"),
        ({"rotors.thrust": 1.0}, "rotors.thrust", "unknown key"),
        ({"inertia_kg_m2": [0.01, 0.01]}, "inertia_kg_m2.2", "missing"),
        ({"inertia_kg_m2": [0.01, 0.01, 0.05]}, "inertia_kg_m2", "rigid body"),
        ({"rotors.layout": []}, "rotors.layout", "at least 4"),
        ({"rotors.max_speed_rad_s": 100.0}, "rotors.max_speed_rad_s", "hovering would take"),
        ({"rotors.min_speed_rad_s": 900.0}, "rotors.min_speed_rad_s", "slower than hovering"),
        ({"battery.full_voltage_v": 3.0}, "battery.empty_voltage_v", "below full_voltage_v"),
        ({"px4_parameters": {"MPC_XY_P": 7.0}}, "px4_parameters.MPC_XY_P", "less than or equal to 2"),
        ({"px4_parameters": {"MPC_XY_Q": 1.0}}, "px4_parameters.MPC_XY_Q", "unknown key"),
    ],
)
def test_wrong_values_are_named(tmp_path: Path, edit: dict[str, Any], key: str, reason: str) -> None:
    file = edited(tmp_path, edit)
    with pytest.raises(ConfigError) as refusal:
        load_vehicle(file)
    assert refusal.value.key == key
    assert reason in refusal.value.reason
    assert str(refusal.value).startswith(f"{file}: {key}: ")
    assert "\n" not in str(refusal.value)


def test_rotors_that_cannot_steer_are_refused(tmp_path: Path) -> None:
    text = MINIMAL.replace("direction: cw}", "direction: ccw}")
    with pytest.raises(ConfigError, match=r"rotors\.layout"):
        load_vehicle(write(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("mass_kg: [", "not readable as YAML"),
        ("", "expected `key: value` lines"),
        ("just words", "expected `key: value` lines"),
        ("mass_kg: 1.0", "inertia_kg_m2: missing"),
        ("mass_kg: 1.0\nmass_kg: 2.0", "mass_kg: given twice"),
    ],
)
def test_files_that_are_no_vehicle(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(ConfigError) as refusal:
        load_vehicle(write(tmp_path, text))
    assert reason in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_unknown_names_list_the_known_ones() -> None:
    with pytest.raises(ConfigError, match=r"bebop3: .*ardrone2, .*bebop2"):
        load_vehicle("bebop3")
    with pytest.raises(ConfigError, match=r"\./none\.yaml"):
        load_conditions("./none.yaml")


def test_conditions_of_one_s_own(tmp_path: Path) -> None:
    own = load_conditions(write(tmp_path, "wind:\n  mean_speed_m_s: 3\n"))
    assert own.wind.mean_speed_m_s == 3.0
    assert own.estimator == EstimatorErrors()
    with pytest.raises(ConfigError, match=r"link\.telemetry_loss_fraction"):
        load_conditions(write(tmp_path, "link:\n  telemetry_loss_fraction: 1.5\n"))


def test_what_conditions_leave_out_is_as_in_their_base(tmp_path: Path) -> None:
    realistic = load_conditions("realistic")
    own = load_conditions(write(tmp_path, "based_on: realistic\nwind:\n  w20_kn: 30\n"))
    assert (own.name, own.description) == ("mine", "")
    assert (own.estimator, own.link) == (realistic.estimator, realistic.link)
    assert own.wind == WindConditions(w20_kn=30.0)


@pytest.mark.parametrize("name", ["payload_pickup", "payload_drop", "battery_sag"])
def test_conditions_that_change_in_flight_rest_on_the_realistic_ones(name: str) -> None:
    changing, realistic = load_conditions(name), load_conditions("realistic")
    same = {"wind", "estimator", "link", "errors_against"}
    assert changing.model_dump(include=same) == realistic.model_dump(include=same)
    assert (changing.payload is None) == (changing.battery.sag_fraction > 0.0)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("based_on: stormy", "based_on"),
        ("based_on: 7", "based_on"),
        ("payload: {mass_fraction: 1.5}", "payload.mass_fraction"),
        ("payload: {mass_fraction: 0.3, taken_at_s: 5, dropped_at_s: 5}", "payload.dropped_at_s"),
        ("battery: {sag_fraction: 0.6}", "battery.sag_fraction"),
        ("battery: {sag_over_s: 0}", "battery.sag_over_s"),
    ],
)
def test_wrong_conditions_are_named(tmp_path: Path, text: str, key: str) -> None:
    with pytest.raises(ConfigError) as refusal:
        load_conditions(write(tmp_path, text))
    assert refusal.value.key == key


def test_every_key_is_documented() -> None:
    documented = SCHEMA.read_text(encoding="utf-8")
    sections: tuple[type[BaseModel], ...] = (Vehicle, Rotors, RotorPlace, BodyDrag, BatteryPack)
    sections += (WindConditions, LinkConditions, EstimatorErrors, PositionError, VelocityError)
    sections += (AttitudeError, RatesError, Conditions, OwnErrors, PayloadConditions, BatteryConditions)
    for section in sections:
        for key in section.model_fields:
            assert key in documented

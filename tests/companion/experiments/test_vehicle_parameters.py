"""Numbers of vehicle files by dotted key."""

from pathlib import Path

import pytest
import yaml

from companion.errors import InputError
from companion.experiments.fitted_file import fitted_file
from companion.experiments.vehicle_parameters import (
    default_parameters,
    file_values,
    known_keys,
    parameter,
    with_values,
)
from sitl.estimator_errors import EstimatorErrors, PositionError
from sitl.firmware.px4_tuning import tuned_parameters
from sitl.vehicle import load_vehicle

BEBOP2 = load_vehicle("bebop2")
BEBOP2_FILE = Path(__file__).parents[3] / "config/vehicles/bebop2.yaml"


def test_keys_are_numbers_of_this_firmware() -> None:
    keys = known_keys(BEBOP2)
    assert {"mass_kg", "rotors.time_constant_s", "px4_parameters.MPC_XY_P"} <= set(keys)
    assert not [key for key in keys if key.startswith(("ardupilot_parameters", "rotors.layout", "name"))]
    assert [key for key in keys if key.startswith("estimator")] == [
        f"estimator.{quantity}.delay_s" for quantity in ("attitude", "position", "rates", "velocity")
    ]


@pytest.mark.parametrize("name", ["bebop2", "arducopter_sitl"])
def test_every_firmware_has_something_to_fit(name: str) -> None:
    assert len(default_parameters(load_vehicle(name))) >= 4


def test_bounds_are_the_formats_own_or_four_times_the_start() -> None:
    lag = parameter(BEBOP2, "rotors.time_constant_s")
    assert (lag.low, lag.start, lag.high) == (0.003125, 0.0125, 0.05)
    gain = parameter(BEBOP2, "px4_parameters.MPC_XY_VEL_P_ACC")
    assert (gain.low, gain.start, gain.high) == (1.2, 1.8, 5.0)
    assert parameter(BEBOP2, "rotors.delay_s").high == 0.2


def test_a_gain_that_is_tuned_to_the_airframe_starts_there() -> None:
    gain = parameter(BEBOP2, "px4_parameters.MC_ROLLRATE_P")
    assert gain.start == tuned_parameters(BEBOP2).MC_ROLLRATE_P != 0.15


def test_a_list_keeps_its_ratios() -> None:
    drag = "body_drag.quadratic_n_s2_per_m2"
    assert parameter(BEBOP2, drag).start == pytest.approx((0.009 + 0.009 + 0.035) / 3)
    heavier = with_values(BEBOP2, {drag: 2 * parameter(BEBOP2, drag).start, "mass_kg": 0.6})
    assert heavier.body_drag.quadratic_n_s2_per_m2 == pytest.approx((0.018, 0.018, 0.07))
    assert heavier.mass_kg == 0.6
    assert heavier.rotors == BEBOP2.rotors


@pytest.mark.parametrize(
    ("key", "expected"),
    [
        ("rotors.lag", r"unknown parameter rotors\.lag; there are .*rotors\.time_constant_s"),
        ("rotors.layout", "unknown parameter"),
        ("rotors.drag_coefficient_n_s2_per_m", "no value to start from"),
        ("body_drag.linear_n_s_per_m", "starts at 0"),
    ],
)
def test_what_cannot_be_varied_is_told(key: str, expected: str) -> None:
    bare = BEBOP2.model_dump(exclude_unset=True)
    del bare["body_drag"], bare["rotors"]["drag_coefficient_n_s2_per_m"]
    with pytest.raises(InputError, match=expected):
        parameter(type(BEBOP2).model_validate(bare), key)


def test_values_that_no_file_may_hold_are_refused() -> None:
    with pytest.raises(InputError, match="hovering"):
        with_values(BEBOP2, {"mass_kg": 2.0})


def test_a_fitted_file_says_what_is_new_and_keeps_the_rest(tmp_path: Path) -> None:
    values = {
        "rotors.time_constant_s": 0.0123456,
        "rotors.delay_s": 1.23456e-5,
        "body_drag.linear_n_s_per_m": 0.01,
    }
    errors = EstimatorErrors(position=PositionError(noise_m=(0.1, 1e-5, 0.3)))
    text = fitted_file(BEBOP2_FILE, file_values(BEBOP2, values), errors, ["Fitted to a.tlog."])
    assert text.startswith("# Fitted to a.tlog.\n")
    assert "# LADAC: iff-gsc/LADAC-Examples-Data" in text
    file = tmp_path / "mine.yaml"
    file.write_text(text, encoding="utf-8")
    mine = load_vehicle(file)
    assert mine.rotors.time_constant_s == 0.01235
    assert mine.rotors.delay_s == pytest.approx(1.235e-5)
    assert mine.body_drag.linear_n_s_per_m == pytest.approx((0.03, 0.0, 0.0))
    assert mine.estimator == errors
    assert mine.battery == BEBOP2.battery
    old = yaml.safe_load(BEBOP2_FILE.read_text())
    assert list(yaml.safe_load(text)) == [*old, "estimator"]

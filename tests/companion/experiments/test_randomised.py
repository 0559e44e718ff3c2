import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import InputError
from companion.experiments.randomised import DELAY_S, Variation, drawn, varied, varied_file
from sitl.vehicle import load_vehicle

HEAVIER = Variation(mass=1.2, drag=0.5, delay_s=0.01)


@given(st.floats(0.0, 0.5), st.integers(0, 1000))
def test_a_draw_stays_within_its_spread_and_repeats(spread: float, seed: int) -> None:
    variation = drawn(spread, np.random.default_rng(seed))
    assert max(abs(variation.mass - 1.0), abs(variation.drag - 1.0)) <= spread
    assert 0.0 <= variation.delay_s <= spread * DELAY_S
    assert variation == drawn(spread, np.random.default_rng(seed))


@pytest.mark.parametrize("name", ["ardrone2", "x500", "arducopter_sitl"])
def test_mass_drag_and_delay_are_what_varies(name: str) -> None:
    before = load_vehicle(name)
    after = varied(before, HEAVIER)
    assert after.mass_kg == pytest.approx(1.2 * before.mass_kg)
    assert after.rotor_drag_n_s2_per_m == pytest.approx(0.5 * before.rotor_drag_n_s2_per_m)
    assert after.rotors.delay_s == pytest.approx(before.rotors.delay_s + 0.01)
    for part in ("linear_n_s_per_m", "quadratic_n_s2_per_m2"):
        np.testing.assert_allclose(
            getattr(after.body_drag, part), 0.5 * np.array(getattr(before.body_drag, part))
        )
    assert after.inertia_kg_m2 == before.inertia_kg_m2
    assert after.max_speed_rad_s == before.max_speed_rad_s


def test_a_file_of_the_varied_vehicle_is_there_while_it_is_flown() -> None:
    with varied_file("bebop2", HEAVIER) as path:
        assert load_vehicle(path) == varied(load_vehicle("bebop2"), HEAVIER)
    assert not path.exists()


def test_a_vehicle_that_could_not_fly_is_refused() -> None:
    with pytest.raises(InputError, match="hovering would take"):
        varied(load_vehicle("bebop2"), Variation(mass=4.0, drag=1.0, delay_s=0.0))

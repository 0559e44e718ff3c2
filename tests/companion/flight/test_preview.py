"""The state that a trajectory itself has."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from companion.flight.approach import rest_to_rest
from companion.flight.preview import flat_state
from companion.trajectory.trajectory import Sample

GRAVITY_M_S2 = 9.80665
LINE = rest_to_rest(np.zeros(3), np.array((2.0, 1.0, -1.0)), "line")


class Accelerating:
    """The acceleration north grows by 1 m/s² a second from 3, that east is 4: it never was at rest."""

    def at(self, time_s: float) -> Sample:
        return Sample(np.ones(3), np.full(3, 2.0), np.array((3.0 + time_s, 4.0, 0.0)))


def test_a_vehicle_at_rest_is_level() -> None:
    x = flat_state(LINE, LINE.duration_s + 1.0)
    np.testing.assert_allclose(x[0:3], (2.0, 1.0, -1.0))
    np.testing.assert_array_equal(x[3:], 0.0)


@given(st.floats(0.0, 1.0))
def test_the_tilt_makes_the_acceleration(share: float) -> None:
    desired = LINE.at(share * LINE.duration_s)
    x = flat_state(LINE, share * LINE.duration_s)
    np.testing.assert_array_equal(x[0:6], np.concatenate((desired.position, desired.velocity)))
    roll, pitch = x[6:8]
    body_down = np.array((np.cos(roll) * np.sin(pitch), -np.sin(roll), np.cos(roll) * np.cos(pitch)))
    thrust = np.linalg.norm(desired.acceleration - (0.0, 0.0, GRAVITY_M_S2))
    np.testing.assert_allclose((0.0, 0.0, GRAVITY_M_S2) - thrust * body_down, desired.acceleration, atol=1e-9)


def test_to_go_north_the_nose_goes_down_and_to_go_east_the_right_side() -> None:
    roll, pitch, yaw, p, q, r = flat_state(Accelerating(), 0.0)[6:]
    assert pitch == -np.arctan2(3.0, GRAVITY_M_S2)
    assert roll > 0.0
    assert (yaw, r) == (0.0, 0.0)
    np.testing.assert_allclose(q, -GRAVITY_M_S2 / (GRAVITY_M_S2**2 + 9.0), rtol=1e-4)
    assert p < 0.0  # the more of the thrust goes north, the less roll it takes

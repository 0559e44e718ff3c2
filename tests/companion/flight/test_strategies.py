"""How the strategies make u1."""

import numpy as np
import pytest

from companion.flight.approach import rest_to_rest
from companion.flight.reference import Reference
from companion.flight.strategies import Tempered, position_velocity_acceleration
from companion.state import VehicleState
from companion.trajectory.trajectory import Trajectory

LINE = rest_to_rest(np.zeros(3), np.array((2.0, 0.0, -1.0)), "line")
STATE = VehicleState(0.0, 0.0, *np.zeros((4, 3)))
OFFSET, EXTRA = np.array((0.4, -0.2, 0.1)), np.array((1.0, 0.5, -0.5))


def beside(trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
    desired = trajectory.at(time_s)
    return Reference(desired.position + OFFSET, desired.velocity + EXTRA)


@pytest.mark.parametrize("share", [0.25, 0.5, 1.0])
def test_tempered_goes_only_a_share_of_the_way(share: float) -> None:
    desired = LINE.at(0.7)
    tempered = Tempered(beside, share)(LINE, 0.7, STATE)
    np.testing.assert_allclose(tempered.position, desired.position + share * OFFSET)
    np.testing.assert_allclose(tempered.velocity, desired.velocity + share * EXTRA)
    assert tempered.acceleration is not None
    np.testing.assert_allclose(tempered.acceleration, (1.0 - share) * desired.acceleration)


def test_without_a_share_it_is_plain() -> None:
    tempered = Tempered(beside, 0.0)(LINE, 0.7, STATE)
    plain = position_velocity_acceleration(LINE, 0.7, STATE)
    np.testing.assert_allclose(tempered.position, plain.position)
    assert tempered.acceleration is not None
    assert plain.acceleration is not None
    np.testing.assert_allclose(tempered.acceleration, plain.acceleration)

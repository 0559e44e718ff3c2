"""How strongly an autopilot answers to setpoints, as its parameters have it."""

import numpy as np
import pytest
from fake_autopilots import FakeArduPilot, FakePx4

from companion import clock
from companion.autopilot.ardupilot import ArduPilot
from companion.autopilot.position_loop import PositionLoop
from companion.autopilot.px4 import Px4
from companion.errors import NoReplyError


def loop(vehicle: FakePx4, parameters: dict[str, float]) -> PositionLoop:
    async def scenario() -> PositionLoop:
        vehicle.parameters = parameters
        async with vehicle.flown() as (connection, telemetry):
            autopilot = ArduPilot if isinstance(vehicle, FakeArduPilot) else Px4
            return await autopilot(connection, telemetry).position_loop()

    return clock.run(scenario(), virtual=True)


def test_px4s_is_position_gain_over_velocity_gain() -> None:
    gains = {"MPC_XY_P": 1.5, "MPC_Z_P": 1.0, "MPC_XY_VEL_P_ACC": 3.0, "MPC_Z_VEL_P_ACC": 4.0}
    stiffness, damping = loop(FakePx4(), gains)
    np.testing.assert_allclose(stiffness, [4.5, 4.5, 4.0])
    np.testing.assert_allclose(damping, [3.0, 3.0, 4.0])


@pytest.mark.parametrize(
    "names",
    [
        ("PSC_POSXY_P", "PSC_POSZ_P", "PSC_VELXY_P", "PSC_VELZ_P"),
        ("PSC_NE_POS_P", "PSC_D_POS_P", "PSC_NE_VEL_P", "PSC_D_VEL_P"),
    ],
)
def test_ardupilots_is_found_by_its_old_and_new_names(names: tuple[str, ...]) -> None:
    told = loop(FakeArduPilot(), dict(zip(names, (2.0, 1.0, 2.0, 10.0), strict=True)))
    usual = ArduPilot.usual_position_loop
    np.testing.assert_allclose(told.stiffness_1_s2 / usual.stiffness_1_s2, [2.0, 2.0, 2.0])
    np.testing.assert_allclose(told.damping_1_s / usual.damping_1_s, [1.0, 1.0, 2.0])


@pytest.mark.parametrize("gain", [0.0, -1.0, np.nan])
def test_gains_that_make_no_loop_are_not_believed(gain: float) -> None:
    with pytest.raises(NoReplyError, match=r"tells no gains of its position loop \(MPC_XY_P"):
        loop(FakePx4(), {"MPC_XY_P": gain, "MPC_Z_P": 1.0, "MPC_XY_VEL_P_ACC": 3.0, "MPC_Z_VEL_P_ACC": 4.0})

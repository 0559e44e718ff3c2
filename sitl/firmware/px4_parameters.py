"""PX4 parameters that act on the simulated firmware: PX4's names, units, defaults and ranges.

Source: PX4 parameter reference, https://docs.px4.io/main/en/advanced_config/parameter_reference.html
"""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class Px4Parameters(BaseModel):
    """One value a parameter; angles in degrees and thrusts as a fraction of the maximum, as in PX4."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    # Position and velocity control
    MPC_XY_P: float = Field(0.95, ge=0.0, le=2.0)
    MPC_Z_P: float = Field(1.0, ge=0.1, le=1.5)
    MPC_XY_VEL_P_ACC: float = Field(1.8, ge=1.2, le=5.0)
    MPC_XY_VEL_I_ACC: float = Field(0.4, ge=0.0, le=60.0)
    MPC_XY_VEL_D_ACC: float = Field(0.2, ge=0.1, le=2.0)
    MPC_Z_VEL_P_ACC: float = Field(4.0, ge=2.0, le=15.0)
    MPC_Z_VEL_I_ACC: float = Field(2.0, ge=0.2, le=3.0)
    MPC_Z_VEL_D_ACC: float = Field(0.0, ge=0.0, le=2.0)
    MPC_VEL_LP: float = Field(0.0, ge=0.0, le=50.0)
    MPC_VELD_LP: float = Field(5.0, ge=0.0, le=50.0)
    MPC_XY_VEL_MAX: float = Field(12.0, ge=0.0, le=20.0)
    MPC_Z_VEL_MAX_UP: float = Field(3.0, ge=0.5, le=8.0)
    MPC_Z_VEL_MAX_DN: float = Field(1.5, ge=0.5, le=4.0)
    MPC_TILTMAX_AIR: float = Field(45.0, ge=20.0, le=89.0)
    MPC_TILTMAX_LND: float = Field(12.0, ge=10.0, le=89.0)
    MPC_THR_HOVER: float = Field(0.5, ge=0.1, le=0.8)
    MPC_THR_MIN: float = Field(0.12, ge=0.01, le=0.5)
    MPC_THR_MAX: float = Field(1.0, ge=0.0, le=1.0)
    MPC_THR_XY_MARG: float = Field(0.3, ge=0.0, le=0.5)
    MPC_ACC_DECOUPLE: Literal[0, 1] = 1

    # Hover thrust: whether it is estimated in flight, and how
    MPC_USE_HTE: Literal[0, 1] = 1
    HTE_HT_NOISE: float = Field(0.0036, ge=0.0001, le=1.0)
    HTE_HT_ERR_INIT: float = Field(0.1, ge=0.0, le=1.0)
    HTE_ACC_GATE: float = Field(3.0, ge=1.0, le=10.0)
    HTE_THR_RANGE: float = Field(0.2, ge=0.01, le=0.4)
    HTE_VXY_THR: float = Field(10.0, ge=1.0, le=20.0)
    HTE_VZ_THR: float = Field(2.0, ge=1.0, le=10.0)

    # Autonomous flight
    MPC_XY_CRUISE: float = Field(5.0, ge=3.0, le=20.0)
    MPC_ACC_HOR: float = Field(3.0, ge=2.0, le=15.0)
    MPC_JERK_AUTO: float = Field(4.0, ge=1.0, le=80.0)
    MPC_TKO_SPEED: float = Field(1.5, ge=1.0, le=5.0)
    MPC_TKO_RAMP_T: float = Field(3.0, ge=0.0, le=5.0)
    MPC_LAND_SPEED: float = Field(0.7, ge=0.6, le=4.0)
    MIS_TAKEOFF_ALT: float = Field(2.5, ge=0.0, le=80.0)
    RTL_RETURN_ALT: float = Field(60.0, ge=0.0)

    # Attitude control
    MC_ROLL_P: float = Field(6.5, ge=0.0, le=12.0)
    MC_PITCH_P: float = Field(6.5, ge=0.0, le=12.0)
    MC_YAW_P: float = Field(2.8, ge=0.0, le=5.0)
    MC_YAW_WEIGHT: float = Field(0.4, ge=0.0, le=1.0)
    MC_ROLLRATE_MAX: float = Field(220.0, ge=0.0, le=1800.0)
    MC_PITCHRATE_MAX: float = Field(220.0, ge=0.0, le=1800.0)
    MC_YAWRATE_MAX: float = Field(200.0, ge=0.0, le=1800.0)

    # Rate control: torque as a fraction of what the control allocation calls full torque
    MC_ROLLRATE_P: float = Field(0.15, ge=0.01, le=0.6)
    MC_ROLLRATE_I: float = Field(0.2, ge=0.0)
    MC_ROLLRATE_D: float = Field(0.003, ge=0.0, le=0.01)
    MC_PITCHRATE_P: float = Field(0.15, ge=0.01, le=0.6)
    MC_PITCHRATE_I: float = Field(0.2, ge=0.0)
    MC_PITCHRATE_D: float = Field(0.003, ge=0.0, le=0.02)
    MC_YAWRATE_P: float = Field(0.2, ge=0.0, le=0.6)
    MC_YAWRATE_I: float = Field(0.1, ge=0.0)
    MC_YAWRATE_D: float = Field(0.0, ge=0.0)
    MC_RR_INT_LIM: float = Field(0.3, ge=0.0)
    MC_PR_INT_LIM: float = Field(0.3, ge=0.0)
    MC_YR_INT_LIM: float = Field(0.3, ge=0.0)
    MC_YAW_TQ_CUTOFF: float = Field(2.0, ge=0.0, le=10.0)
    IMU_GYRO_CUTOFF: float = Field(40.0, ge=0.0, le=1000.0)
    IMU_DGYRO_CUTOFF: float = Field(30.0, ge=0.0, le=1000.0)

    # Commander: arming, failsafes, battery
    COM_SPOOLUP_TIME: float = Field(1.0, ge=0.0, le=5.0)
    COM_DISARM_PRFLT: float = Field(10.0)
    COM_DISARM_LAND: float = Field(2.0)
    COM_OF_LOSS_T: float = Field(1.0, ge=0.0, le=60.0)
    COM_OBL_RC_ACT: Literal[0, 3, 4, 5] = 0
    """Position (without a pilot: hold), Return, Land, Hold."""
    BAT_LOW_THR: float = Field(0.15, ge=0.12, le=0.5)
    BAT_CRIT_THR: float = Field(0.07, ge=0.05, le=0.5)
    BAT_EMERGEN_THR: float = Field(0.05, ge=0.03, le=0.5)

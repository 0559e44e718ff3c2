"""PX4 parameters that act on the simulated firmware: PX4's names, units, defaults and ranges.

Source: PX4 parameter reference, https://docs.px4.io/main/en/advanced_config/parameter_reference.html
"""

from typing import Literal

from pydantic import Field

from sitl.firmware.parameters import Parameters


class Px4Parameters(Parameters):
    """One value a parameter; angles in degrees and thrusts as a fraction of the maximum, as in PX4."""

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
    MPC_VEL_MANUAL: float = Field(10.0, ge=3.0, le=20.0)
    MPC_MAN_Y_MAX: float = Field(150.0, ge=0.0, le=400.0)
    MPC_XY_CRUISE: float = Field(5.0, ge=3.0, le=20.0)
    MPC_ACC_HOR: float = Field(3.0, ge=2.0, le=15.0)
    MPC_JERK_AUTO: float = Field(4.0, ge=1.0, le=80.0)
    MPC_YAW_MODE: Literal[0, 1, 2, 3, 4] = 0
    """Where a mission looks: along its path, at home, or away from home (2); here 3 and 4 are as 0."""
    MPC_TKO_SPEED: float = Field(1.5, ge=1.0, le=5.0)
    MPC_TKO_RAMP_T: float = Field(3.0, ge=0.0, le=5.0)
    MPC_LAND_SPEED: float = Field(0.7, ge=0.6, le=4.0)
    MIS_TAKEOFF_ALT: float = Field(2.5, ge=0.0, le=80.0)
    MIS_DIST_1WP: float = Field(10000.0, ge=-1.0, le=100000.0)
    NAV_ACC_RAD: float = Field(2.0, ge=0.05, le=200.0)
    NAV_MC_ALT_RAD: float = Field(0.8, ge=0.05, le=200.0)
    RTL_TYPE: Literal[0, 1, 2, 3, 4, 5] = 0
    RTL_RETURN_ALT: float = Field(30.0, ge=0.0)
    RTL_DESCEND_ALT: float = Field(10.0, ge=0.0)
    RTL_LAND_DELAY: float = Field(0.0, ge=-1.0)
    RTL_MIN_DIST: float = Field(10.0, ge=0.5, le=100.0)
    RTL_CONE_ANG: Literal[0, 25, 45, 65, 80, 90] = 45

    # Geofence
    GF_ACTION: Literal[0, 1, 2, 3, 4, 5] = 2
    """None, Warning, Hold, Return, Terminate, Land."""
    GF_MAX_HOR_DIST: float = Field(0.0, ge=0.0, le=10000.0)
    GF_MAX_VER_DIST: float = Field(0.0, ge=0.0, le=10000.0)

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
    COM_OBL_RC_ACT: Literal[0, 1, 2, 3, 4, 5, 6, 7] = 0
    """Position, Altitude, Manual (without a pilot: hold), Return, Land, Hold, Terminate, Disarm."""
    COM_RCL_EXCEPT: int = Field(0, ge=0, le=31)
    """Where the loss of the pilot's control is ignored: bits for Mission, Hold, Offboard."""
    COM_RC_OVERRIDE: int = Field(1, ge=0, le=3)
    """Whether moved sticks end a mode: bits for the automatic ones and Offboard."""
    COM_RC_STICK_OV: float = Field(30.0, ge=5.0, le=80.0)
    COM_RC_IN_MODE: int = Field(3, ge=0, le=8)
    """4: no pilot's control is wanted."""
    COM_RC_LOSS_T: float = Field(0.5, ge=0.0, le=35.0)
    NAV_RCL_ACT: Literal[1, 2, 3, 5, 6] = 2
    """When the pilot's control is gone: Hold, Return, Land, Terminate, Disarm."""
    COM_DL_LOSS_T: int = Field(10, ge=5, le=300)
    COM_FAIL_ACT_T: float = Field(5.0, ge=0.0, le=25.0)
    NAV_DLL_ACT: Literal[0, 1, 2, 3, 5, 6] = 0
    """When the ground station is gone: nothing, Hold, Return, Land, Terminate, Disarm."""
    SYS_FAILURE_EN: Literal[0, 1] = 0
    MAV_SYS_ID: int = Field(1, ge=1, le=255)
    SYS_AUTOSTART: int = Field(4001, ge=0, le=9999999)
    """PX4's generic quadrotor; acts on nothing, but ground stations take 0 for a vehicle without airframe."""
    COM_LOW_BAT_ACT: Literal[0, 2, 3] = 0
    """When the battery is critical: a warning, Land, or Return and Land when it is nearly empty."""
    BAT_LOW_THR: float = Field(0.15, ge=0.12, le=0.5)
    BAT_CRIT_THR: float = Field(0.07, ge=0.05, le=0.5)
    BAT_EMERGEN_THR: float = Field(0.05, ge=0.03, le=0.5)

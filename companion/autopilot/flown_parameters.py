"""The parameters that say how an autopilot flies: what a recording of a flight must have to be understood.

Sources: https://docs.px4.io/main/en/advanced_config/parameter_reference.html and
https://ardupilot.org/copter/docs/parameters.html, where some have other names from Copter 4.7 on.
"""

from collections.abc import Mapping, Sequence

_PX4 = (
    *("MPC_XY_P", "MPC_Z_P", "MPC_XY_VEL_P_ACC", "MPC_Z_VEL_P_ACC"),
    *("MPC_XY_VEL_I_ACC", "MPC_Z_VEL_I_ACC", "MPC_XY_VEL_D_ACC", "MPC_Z_VEL_D_ACC"),
    *("MC_ROLL_P", "MC_PITCH_P", "MC_YAW_P", "MPC_THR_HOVER", "MPC_USE_HTE"),
    *("MPC_XY_VEL_MAX", "MPC_Z_VEL_MAX_UP", "MPC_Z_VEL_MAX_DN", "MPC_TILTMAX_AIR"),
    *("COM_OF_LOSS_T", "COM_OBL_RC_ACT", "COM_RC_IN_MODE", "COM_RCL_EXCEPT", "NAV_RCL_ACT", "NAV_DLL_ACT"),
    *("COM_LOW_BAT_ACT", "BAT_LOW_THR", "BAT_CRIT_THR", "BAT_EMERGEN_THR"),
    *("GF_ACTION", "GF_MAX_HOR_DIST", "GF_MAX_VER_DIST", "RTL_RETURN_ALT"),
)
_ARDUPILOT = (
    *("PSC_POSXY_P", "PSC_POSZ_P", "PSC_VELXY_P", "PSC_VELZ_P"),
    *("PSC_VELXY_I", "PSC_VELXY_D", "PSC_VELXY_FF", "PSC_ACCZ_P", "PSC_ACCZ_I", "PSC_JERK_XY"),
    *("ATC_ANG_RLL_P", "ATC_ANG_PIT_P", "ATC_ANG_YAW_P", "MOT_THST_HOVER", "MOT_HOVER_LEARN"),
    *("WPNAV_SPEED", "WPNAV_SPEED_UP", "WPNAV_SPEED_DN", "WPNAV_ACCEL", "WPNAV_ACCEL_Z", "ANGLE_MAX"),
    *("GUID_TIMEOUT", "GUID_OPTIONS", "FS_GCS_ENABLE", "FS_THR_ENABLE", "FS_EKF_ACTION", "FS_OPTIONS"),
    *("BATT_FS_LOW_ACT", "BATT_LOW_VOLT"),
    *(
        "FENCE_ENABLE",
        "FENCE_TYPE",
        "FENCE_ACTION",
        "FENCE_ALT_MIN",
        "FENCE_ALT_MAX",
        "FENCE_RADIUS",
        "FENCE_MARGIN",
    ),
    *("PSC_NE_POS_P", "PSC_D_POS_P", "PSC_NE_VEL_P", "PSC_D_VEL_P"),
    *("WP_SPD", "WP_SPD_UP", "WP_SPD_DN", "WP_ACC", "WP_ACC_Z"),
)
FLOWN_BY: Mapping[str, Sequence[str]] = {"PX4": _PX4, "ArduPilot": _ARDUPILOT}
"""By autopilot: gains of its loops, hover thrust, limits, failsafes and fence, what matters most first."""

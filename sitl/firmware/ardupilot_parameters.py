"""ArduPilot Copter parameters that act on the simulated firmware: ArduPilot's names, units, defaults, ranges.

Names are those of Copter 4.5 and 4.6; 4.7 gave some of them new names and SI units before its release.

Source: complete parameter list, https://ardupilot.org/copter/docs/parameters.html
"""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class ArduPilotParameters(BaseModel):
    """One value a parameter; lengths in cm and angles in centidegrees wherever ArduPilot has them so."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    # Limits of the path that GUIDED shapes
    WPNAV_SPEED: float = Field(1000.0, ge=10.0, le=2000.0)
    WPNAV_SPEED_UP: float = Field(250.0, ge=10.0, le=1000.0)
    WPNAV_SPEED_DN: float = Field(150.0, ge=10.0, le=500.0)
    WPNAV_ACCEL: float = Field(250.0, ge=50.0, le=500.0)
    WPNAV_ACCEL_Z: float = Field(100.0, ge=50.0, le=500.0)
    PSC_JERK_XY: float = Field(5.0, ge=1.0, le=20.0)
    PSC_JERK_Z: float = Field(5.0, ge=1.0, le=50.0)
    GUID_TIMEOUT: float = Field(3.0, ge=0.1, le=5.0)

    # Position control
    PSC_POSXY_P: float = Field(1.0, ge=0.1, le=4.0)
    PSC_VELXY_P: float = Field(2.0, ge=0.1, le=6.0)
    PSC_VELXY_I: float = Field(1.0, ge=0.0, le=6.0)
    PSC_VELXY_D: float = Field(0.5, ge=0.0, le=2.0)
    PSC_VELXY_FF: float = Field(0.0, ge=0.0, le=6.0)
    PSC_VELXY_IMAX: float = Field(1000.0, ge=0.0, le=4500.0)
    PSC_VELXY_FLTE: float = Field(5.0, ge=0.0, le=100.0)
    PSC_VELXY_FLTD: float = Field(5.0, ge=0.0, le=100.0)
    PSC_POSZ_P: float = Field(1.0, ge=0.1, le=4.0)
    PSC_VELZ_P: float = Field(5.0, ge=0.1, le=10.0)
    PSC_VELZ_I: float = Field(0.0, ge=0.0, le=10.0)
    PSC_VELZ_IMAX: float = Field(1000.0, ge=0.0, le=4500.0)
    PSC_VELZ_FLTE: float = Field(5.0, ge=0.0, le=100.0)
    PSC_ACCZ_P: float = Field(0.5, ge=0.01, le=1.5)
    PSC_ACCZ_I: float = Field(1.0, ge=0.0, le=3.0)
    PSC_ACCZ_D: float = Field(0.0, ge=0.0, le=0.4)
    PSC_ACCZ_IMAX: float = Field(800.0, ge=0.0, le=1000.0)
    PSC_ACCZ_FLTE: float = Field(20.0, ge=0.0, le=100.0)
    PSC_ACCZ_FLTD: float = Field(0.0, ge=0.0, le=100.0)
    PSC_ANGLE_MAX: float = Field(0.0, ge=0.0, le=45.0)
    """Degrees; 0: ANGLE_MAX."""
    ANGLE_MAX: float = Field(3000.0, ge=1000.0, le=8000.0)

    # Attitude control
    ATC_INPUT_TC: float = Field(0.15, ge=0.0, le=1.0)
    ATC_ACCEL_R_MAX: float = Field(110000.0, ge=0.0, le=180000.0)
    ATC_ACCEL_P_MAX: float = Field(110000.0, ge=0.0, le=180000.0)
    ATC_ACCEL_Y_MAX: float = Field(27000.0, ge=0.0, le=72000.0)
    ATC_SLEW_YAW: float = Field(6000.0, ge=500.0, le=18000.0)
    ATC_ANG_RLL_P: float = Field(4.5, ge=0.5, le=12.0)
    ATC_ANG_PIT_P: float = Field(4.5, ge=0.5, le=12.0)
    ATC_ANG_YAW_P: float = Field(4.5, ge=0.5, le=12.0)
    ATC_ANG_LIM_TC: float = Field(1.0, ge=0.5, le=10.0)
    ATC_THR_MIX_MAX: float = Field(0.5, ge=0.5, le=0.9)

    # Rate control: output 1 sets a rotor on the axis of the arm half of its range higher
    ATC_RAT_RLL_P: float = Field(0.135, ge=0.001, le=0.5)
    ATC_RAT_RLL_I: float = Field(0.135, ge=0.0, le=2.0)
    ATC_RAT_RLL_D: float = Field(0.0036, ge=0.0, le=0.05)
    ATC_RAT_PIT_P: float = Field(0.135, ge=0.001, le=0.5)
    ATC_RAT_PIT_I: float = Field(0.135, ge=0.0, le=2.0)
    ATC_RAT_PIT_D: float = Field(0.0036, ge=0.0, le=0.05)
    ATC_RAT_YAW_P: float = Field(0.18, ge=0.001, le=2.5)
    ATC_RAT_YAW_I: float = Field(0.018, ge=0.0, le=1.0)
    ATC_RAT_YAW_D: float = Field(0.0, ge=0.0, le=0.02)
    ATC_RAT_RLL_IMAX: float = Field(0.5, ge=0.0, le=1.0)
    ATC_RAT_PIT_IMAX: float = Field(0.5, ge=0.0, le=1.0)
    ATC_RAT_YAW_IMAX: float = Field(0.5, ge=0.0, le=1.0)
    ATC_RAT_RLL_FLTT: float = Field(20.0, ge=0.0, le=100.0)
    ATC_RAT_PIT_FLTT: float = Field(20.0, ge=0.0, le=100.0)
    ATC_RAT_YAW_FLTT: float = Field(20.0, ge=0.0, le=100.0)
    ATC_RAT_RLL_FLTE: float = Field(0.0, ge=0.0, le=100.0)
    ATC_RAT_PIT_FLTE: float = Field(0.0, ge=0.0, le=100.0)
    ATC_RAT_YAW_FLTE: float = Field(2.5, ge=0.0, le=100.0)
    ATC_RAT_RLL_FLTD: float = Field(20.0, ge=0.0, le=100.0)
    ATC_RAT_PIT_FLTD: float = Field(20.0, ge=0.0, le=100.0)
    ATC_RAT_YAW_FLTD: float = Field(0.0, ge=0.0, le=100.0)
    INS_GYRO_FILTER: float = Field(20.0, ge=1.0, le=256.0)
    INS_ACCEL_FILTER: float = Field(20.0, ge=1.0, le=256.0)

    # Motors
    MOT_THST_HOVER: float = Field(0.35, ge=0.1, le=0.8)
    MOT_HOVER_LEARN: Literal[0, 1, 2] = 2
    """0 keeps MOT_THST_HOVER; 1 and 2 learn it in slow flight (nothing is saved either way)."""
    MOT_YAW_HEADROOM: float = Field(200.0, ge=0.0, le=500.0)
    MOT_SPOOL_TIME: float = Field(0.5, ge=0.05, le=2.0)

    # Modes, arming, failsafes
    TKOFF_SLEW_TIME: float = Field(2.0, ge=0.25, le=5.0)
    LAND_SPEED: float = Field(50.0, ge=30.0, le=200.0)
    LAND_ALT_LOW: float = Field(1000.0, ge=100.0, le=10000.0)
    RTL_ALT: float = Field(1500.0, ge=30.0, le=300000.0)
    RTL_LOIT_TIME: float = Field(5000.0, ge=0.0, le=60000.0)
    DISARM_DELAY: float = Field(10.0, ge=0.0, le=127.0)
    BATT_LOW_VOLT: float = Field(10.5, ge=0.0, le=120.0)
    BATT_LOW_TIMER: float = Field(10.0, ge=0.0, le=120.0)
    BATT_FS_LOW_ACT: Literal[0, 1, 2] = 0
    """None, Land, RTL."""

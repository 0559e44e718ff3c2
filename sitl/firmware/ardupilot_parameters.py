"""ArduPilot Copter parameters that act on the simulated firmware: ArduPilot's names, units, defaults, ranges.

Names are those of Copter 4.5 and 4.6; 4.7 gave some of them new names and SI units before its release.

Source: complete parameter list, https://ardupilot.org/copter/docs/parameters.html
"""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from sitl.firmware.parameters import Parameters, Stored

Int8: TypeAlias = Annotated[int, Stored.INT8]
Int16: TypeAlias = Annotated[int, Stored.INT16]
Switch: TypeAlias = Annotated[Literal[0, 1], Stored.INT8]


class ArduPilotParameters(Parameters):
    """One value a parameter; lengths in cm and angles in centidegrees wherever ArduPilot has them so."""

    # Limits of the path that GUIDED shapes
    WPNAV_SPEED: float = Field(1000.0, ge=10.0, le=2000.0)
    WPNAV_SPEED_UP: float = Field(250.0, ge=10.0, le=1000.0)
    WPNAV_SPEED_DN: float = Field(150.0, ge=10.0, le=500.0)
    WPNAV_ACCEL: float = Field(250.0, ge=50.0, le=500.0)
    WPNAV_ACCEL_Z: float = Field(100.0, ge=50.0, le=500.0)
    PSC_JERK_XY: float = Field(5.0, ge=1.0, le=20.0)
    PSC_JERK_Z: float = Field(5.0, ge=1.0, le=50.0)
    GUID_TIMEOUT: float = Field(3.0, ge=0.1, le=5.0)

    LOIT_SPEED: float = Field(1250.0, ge=20.0, le=3500.0)
    PILOT_Y_RATE: float = Field(202.5, ge=1.0, le=360.0)

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
    ANGLE_MAX: Int16 = Field(3000, ge=1000, le=8000)

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
    INS_GYRO_FILTER: Int16 = Field(20, ge=1, le=256)
    INS_ACCEL_FILTER: Int16 = Field(20, ge=1, le=256)

    # Motors
    MOT_THST_HOVER: float = Field(0.35, ge=0.1, le=0.8)
    MOT_HOVER_LEARN: Annotated[Literal[0, 1, 2], Stored.INT8] = 2
    """0 keeps MOT_THST_HOVER; 1 and 2 learn it in slow flight (nothing is saved either way)."""
    MOT_YAW_HEADROOM: Int16 = Field(200, ge=0, le=500)
    MOT_SPOOL_TIME: float = Field(0.5, ge=0.05, le=2.0)

    # Modes, arming, failsafes
    TKOFF_SLEW_TIME: float = Field(2.0, ge=0.25, le=5.0)
    LAND_SPEED: Int16 = Field(50, ge=30, le=200)
    LAND_ALT_LOW: Int16 = Field(1000, ge=100, le=10000)
    RTL_ALT: int = Field(1500, ge=30, le=300000)
    RTL_LOIT_TIME: int = Field(5000, ge=0, le=60000)
    DISARM_DELAY: Int8 = Field(10, ge=0, le=127)
    BATT_LOW_VOLT: float = Field(10.5, ge=0.0, le=120.0)
    BATT_LOW_TIMER: Int16 = Field(10, ge=0, le=120)
    BATT_FS_LOW_ACT: Annotated[Literal[0, 1, 2], Stored.INT8] = 0
    """None, Land, RTL."""
    FS_GCS_ENABLE: Annotated[Literal[0, 1, 3, 4, 5, 6, 7], Stored.INT8] = 0
    """When the ground station of SYSID_MYGCS is gone: nothing, Land for 5, Brake for 7, else RTL."""
    FS_GCS_TIMEOUT: float = Field(5.0, ge=2.0, le=120.0)
    FS_THR_ENABLE: Annotated[Literal[0, 1, 2, 3, 4, 5, 6, 7], Stored.INT8] = 1
    """When the radio is gone: nothing, Land for 3, Brake for 7, else RTL."""
    RC_FS_TIMEOUT: float = Field(1.0, ge=0.5, le=10.0)
    FS_OPTIONS: int = Field(16, ge=0, le=63)
    """Bits: 2 to go on in GUIDED without radio, 3 to go on landing, 4 in the pilot's modes without ground
    station."""
    SYSID_THISMAV: Int16 = Field(1, ge=1, le=255)
    SYSID_MYGCS: Int16 = Field(255, ge=1, le=255)
    ARMING_CHECK: int = Field(1, ge=0, le=0xFFFFF)
    """0: arm whatever the checks say, as long as the mode may be armed in."""

    # Missions, rally points and fences
    WPNAV_RADIUS: float = Field(200.0, ge=5.0, le=1000.0)
    WP_YAW_BEHAVIOR: Annotated[Literal[0, 1, 2, 3], Stored.INT8] = 2
    AUTO_OPTIONS: int = Field(0, ge=0, le=255)
    """Bit 0: arming in AUTO; bit 1: taking off without the pilot's throttle."""
    MIS_TOTAL: Int16 = Field(0, ge=0, le=32766)
    """As RALLY_TOTAL and FENCE_TOTAL: how many items are on board; kept by the vehicle itself."""
    MIS_RESTART: Switch = 0
    RTL_ALT_FINAL: Int16 = Field(0, ge=0, le=1000)
    RTL_CLIMB_MIN: Int16 = Field(0, ge=0, le=3000)
    RTL_SPEED: Int16 = Field(0, ge=0, le=2000)
    RTL_CONE_SLOPE: float = Field(3.0, ge=0.0, le=10.0)
    LAND_SPEED_HIGH: Int16 = Field(0, ge=0, le=500)
    RALLY_TOTAL: Int8 = Field(0, ge=0, le=127)
    RALLY_LIMIT_KM: float = Field(0.3, ge=0.0)
    RALLY_INCL_HOME: Switch = 1
    FENCE_ENABLE: Switch = 0
    FENCE_TYPE: Int8 = Field(7, ge=0, le=15)
    """Bits: altitude, circle around home, inclusions and exclusions, least altitude."""
    FENCE_ACTION: Annotated[Literal[0, 1, 2, 3, 4, 5], Stored.INT8] = 1
    """Report only; RTL or Land; Land; SmartRTL, RTL or Land; Brake or Land; SmartRTL or Land."""
    FENCE_ALT_MAX: float = Field(100.0, ge=10.0, le=1000.0)
    FENCE_ALT_MIN: float = Field(-10.0, ge=-100.0, le=100.0)
    FENCE_RADIUS: float = Field(300.0, ge=30.0, le=10000.0)
    FENCE_MARGIN: float = Field(2.0, ge=1.0, le=10.0)
    FENCE_TOTAL: Int8 = Field(0, ge=0, le=127)

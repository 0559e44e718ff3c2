"""How wrong an autopilot's estimate is, as read from a vehicle's file or from a file of conditions."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

_NotNegative = Annotated[float, Field(ge=0.0)]
Level = _NotNegative | tuple[_NotNegative, _NotNegative, _NotNegative]
"""A standard deviation: one for all axes, or one each."""


class _ErrorProcess(BaseModel):
    """Noise and wander, both first-order Gauss-Markov, and the age of the truth that they are added to."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    correlation_time_s: float = Field(0.0, ge=0.0)
    """Of the noise; 0 is white."""
    rate_hz: float = Field(100.0, ge=1.0, le=1000.0)
    """How often a new noise is drawn, to whole milliseconds; it is held in between."""
    wander_time_s: float = Field(5.0, gt=0.0, le=1e4)
    """Correlation time of the wander."""
    delay_s: float = Field(0.0, ge=0.0, le=0.5)
    """To whole milliseconds."""


class PositionError(_ErrorProcess):
    """Error of the estimated position: north, east, down."""

    noise_m: Level = 0.0
    wander_m: Level = 0.0


class VelocityError(_ErrorProcess):
    """Error of the estimated velocity: north, east, down."""

    noise_m_s: Level = 0.0
    wander_m_s: Level = 0.0


class AttitudeError(_ErrorProcess):
    """Error of the estimated attitude, about each body axis."""

    noise_deg: Level = 0.0
    wander_deg: Level = 0.0


class RatesError(_ErrorProcess):
    """Error of the estimated body rates."""

    noise_deg_s: Level = 0.0
    wander_deg_s: Level = 0.0


class EstimatorErrors(BaseModel):
    """Error of each estimated quantity, and how often the estimator resets."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    position: PositionError = PositionError()
    velocity: VelocityError = VelocityError()
    attitude: AttitudeError = AttitudeError()
    rates: RatesError = RatesError()
    resets_per_hour: float = Field(0.0, ge=0.0, le=3600.0)
    """At a reset the wander of position and velocity starts anew, at once, from another error."""

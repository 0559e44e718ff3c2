"""What a flight has to cope with: wind, estimator errors and the link, as read from `config/conditions/`."""

from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field

from sitl import files


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class WindConditions(_Section):
    """Mean wind, and Dryden turbulence by its wind speed at 20 ft (MIL-F-8785C); all zero: still air."""

    mean_speed_m_s: float = Field(0.0, ge=0.0, le=40.0)
    from_direction_deg: float = Field(0.0, ge=0.0, le=360.0)
    """Where the mean wind comes from, clockwise from north."""
    w20_kn: float = Field(0.0, ge=0.0, le=60.0)


class _ErrorProcess(_Section):
    correlation_time_s: float = Field(0.0, ge=0.0)
    """First-order Gauss-Markov; 0 is white."""
    rate_hz: float = Field(100.0, ge=1.0, le=1000.0)
    """How often a new error is drawn, to whole milliseconds; it is held in between."""


class PositionError(_ErrorProcess):
    """Error of the estimated position, an axis."""

    noise_m: float = Field(0.0, ge=0.0)


class VelocityError(_ErrorProcess):
    """Error of the estimated velocity, an axis."""

    noise_m_s: float = Field(0.0, ge=0.0)


class AttitudeError(_ErrorProcess):
    """Error of the estimated attitude, about each body axis."""

    noise_deg: float = Field(0.0, ge=0.0)


class RatesError(_ErrorProcess):
    """Error of the estimated body rates, an axis."""

    noise_deg_s: float = Field(0.0, ge=0.0)


class EstimatorConditions(_Section):
    """Standard deviation, correlation time and rate of the error of each estimated quantity."""

    position: PositionError = PositionError()
    velocity: VelocityError = VelocityError()
    attitude: AttitudeError = AttitudeError()
    rates: RatesError = RatesError()


class LinkConditions(_Section):
    """Delay and loss between vehicle and companion; applied where the messages are, not in the firmware."""

    telemetry_latency_s: float = Field(0.0, ge=0.0, le=5.0)
    telemetry_jitter_s: float = Field(0.0, ge=0.0, le=5.0)
    """Latency varies by up to this, either way."""
    telemetry_loss_fraction: float = Field(0.0, ge=0.0, lt=1.0)
    setpoint_latency_s: float = Field(0.0, ge=0.0, le=5.0)


class Conditions(_Section):
    """One file of `config/conditions/`; what is left out is ideal."""

    name: str
    description: str = ""
    wind: WindConditions = WindConditions()
    estimator: EstimatorConditions = EstimatorConditions()
    link: LinkConditions = LinkConditions()


def load_conditions(name_or_path: str | Path) -> Conditions:
    """Conditions by name ("realistic") or path of a YAML file.

    Raises:
        ConfigError: unknown name, or a file that is wrong, with file, key and reason.
    """
    return files.load(Conditions, "conditions", name_or_path)

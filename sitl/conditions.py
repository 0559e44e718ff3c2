"""What a flight has to cope with: wind, estimator errors and the link, as read from `config/conditions/`."""

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from sitl import files
from sitl.estimator_errors import EstimatorErrors


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class WindConditions(_Section):
    """Mean wind, and Dryden turbulence by its wind speed at 20 ft (MIL-F-8785C); all zero: still air."""

    mean_speed_m_s: float = Field(0.0, ge=0.0, le=40.0)
    from_direction_deg: float = Field(0.0, ge=0.0, le=360.0)
    """Where the mean wind comes from, clockwise from north."""
    w20_kn: float = Field(0.0, ge=0.0, le=60.0)


class OwnErrors(_Section):
    """Each vehicle's own estimator errors, as its file has them."""

    without: str
    """Name of the vehicle whose errors stand in for a vehicle that has none."""


class LinkConditions(_Section):
    """Delay and loss between vehicle and companion; applied where the messages are, not in the firmware."""

    telemetry_latency_s: float = Field(0.0, ge=0.0, le=5.0)
    telemetry_jitter_s: float = Field(0.0, ge=0.0, le=5.0)
    """Latency varies by up to this, either way."""
    telemetry_loss_fraction: float = Field(0.0, ge=0.0, lt=1.0)
    telemetry_duplicate_fraction: float = Field(0.0, ge=0.0, le=1.0)
    telemetry_overtaken_fraction: float = Field(0.0, ge=0.0, le=1.0)
    setpoint_latency_s: float = Field(0.0, ge=0.0, le=5.0)
    """Of whatever the companion sends."""
    setpoint_jitter_s: float = Field(0.0, ge=0.0, le=5.0)
    setpoint_loss_fraction: float = Field(0.0, ge=0.0, lt=1.0)
    setpoint_duplicate_fraction: float = Field(0.0, ge=0.0, le=1.0)
    setpoint_overtaken_fraction: float = Field(0.0, ge=0.0, le=1.0)


class Conditions(_Section):
    """One file of `config/conditions/`; what is left out is ideal."""

    name: str
    description: str = ""
    wind: WindConditions = WindConditions()
    estimator: EstimatorErrors | OwnErrors = EstimatorErrors()
    link: LinkConditions = LinkConditions()
    errors_against: Literal["truth", "estimate"] = "truth"
    """What the tracking error of a flight is measured against."""


def load_conditions(name_or_path: str | Path) -> Conditions:
    """Conditions by name ("realistic") or path of a YAML file.

    Raises:
        ConfigError: unknown name, or a file that is wrong, with file, key and reason.
    """
    return files.load(Conditions, "conditions", name_or_path)

"""What a flight has to cope with: wind, estimator errors and the link, as read from `config/conditions/`."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from sitl import files
from sitl.estimator_errors import EstimatorErrors
from sitl.files import KeyFaultError


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


Arms = Annotated[float, Field(ge=-2.0, le=2.0)]


class PayloadConditions(_Section):
    """A load that the vehicle carries for a part of its flight, whose time counts from leaving the ground."""

    mass_fraction: float = Field(gt=0.0, le=1.0)
    """Of the vehicle's own mass."""
    place_arms: tuple[Arms, Arms, Arms] = (0.0, 0.0, 0.5)
    """Forward, right and down from the centre of mass, in the rotors' mean distance from it."""
    taken_at_s: float = Field(0.0, ge=0.0)
    """It is there from the beginning at 0."""
    dropped_at_s: float | None = Field(None, gt=0.0)

    @model_validator(mode="after")
    def _taken_before_dropped(self) -> "PayloadConditions":
        if self.dropped_at_s is not None and self.dropped_at_s <= self.taken_at_s:
            raise KeyFaultError("dropped_at_s", "must be later than taken_at_s")
        return self

    def is_carried(self, flight_s: float) -> bool:
        """Whether it is on board at that time of the flight (s)."""
        return self.taken_at_s <= flight_s and (self.dropped_at_s is None or flight_s < self.dropped_at_s)


class BatteryConditions(_Section):
    """How much the voltage sags besides what charge and current take; rotor speeds fall with it."""

    sag_fraction: float = Field(0.0, ge=0.0, le=0.5)
    sag_over_s: float = Field(60.0, gt=0.0)
    """Time of flight over which it grows to that, evenly."""

    def sag(self, flight_s: float) -> float:
        """Share of the voltage that is missing at that time of the flight (s)."""
        return self.sag_fraction * min(1.0, flight_s / self.sag_over_s)


class Conditions(_Section):
    """One file of `config/conditions/`; what is left out is as in the base, or else ideal."""

    name: str
    description: str = ""
    based_on: str | None = None
    """Other conditions, by name, whose sections stand where this file has none."""
    wind: WindConditions = WindConditions()
    estimator: EstimatorErrors | OwnErrors = EstimatorErrors()
    link: LinkConditions = LinkConditions()
    payload: PayloadConditions | None = None
    battery: BatteryConditions = BatteryConditions()
    errors_against: Literal["truth", "estimate"] = "truth"
    """What the tracking error of a flight is measured against."""

    @model_validator(mode="before")
    @classmethod
    def _complete(cls, given: Any) -> Any:
        base = given.get("based_on") if isinstance(given, dict) else None
        if base is None:
            return given
        if base not in files.known_names("conditions") or base == given.get("name"):
            raise KeyFaultError(
                "based_on", f"not the name of other conditions in config/conditions: {base!r}"
            )
        return load_conditions(base).model_dump(exclude={"name", "description", "based_on"}) | given


def load_conditions(name_or_path: str | Path) -> Conditions:
    """Conditions by name ("realistic") or path of a YAML file.

    Raises:
        ConfigError: unknown name, or a file that is wrong, with file, key and reason.
    """
    return files.load(Conditions, "conditions", name_or_path)

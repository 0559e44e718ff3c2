"""The watchdogs of a flight: a limit for each thing that is watched, and what is done beyond it.

Pure functions of what was read; `watching` reads and acts.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any, NamedTuple, TypeAlias

from pydantic import BaseModel, ConfigDict, NonNegativeFloat, PositiveFloat, field_validator, model_validator

from companion.errors import TrackingError


class Action(StrEnum):
    """What a watchdog does."""

    FALL_BACK = "fall back"
    """Go on with the plain strategy: nothing learned, nothing ahead of its time."""
    HOLD = "hold"
    LAND = "land"
    RETURN = "return"
    YIELD = "yield"
    """Send nothing more: whoever has the vehicle then, its pilot or its failsafe, keeps it."""


class WatchdogError(TrackingError):
    """A watchdog ended the flight; `action` says how."""

    def __init__(self, text: str, action: Action) -> None:
        super().__init__(text)
        self.action = action


class Watchdog(BaseModel):
    """One row of the table.

    Attributes:
        limit: beyond it is too much, in the unit that the name of the row has.
        lasts_s: only what is beyond it for so long counts (s).
        action: what is done then.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    limit: PositiveFloat
    lasts_s: NonNegativeFloat = 0.0
    action: Action = Action.HOLD


class Watchdogs(BaseModel):
    """The table."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    state_age_s: Watchdog = Watchdog(limit=0.5)
    """Age of the vehicle's state; from an older one no setpoint is made, so it acts at once."""
    lateness_s: Watchdog = Watchdog(limit=0.9)
    """How late the control loop woke: the process was held up."""
    computing: Watchdog = Watchdog(limit=1.0, lasts_s=0.3, action=Action.FALL_BACK)
    """Time that a control step takes, with its networks and Gaussian processes, as a share of its period."""
    unpredicted_m: Watchdog = Watchdog(limit=0.7, lasts_s=0.5, action=Action.FALL_BACK)
    """How far the tracking error is from what the online model had predicted of it."""
    off_course_m: Watchdog = Watchdog(limit=2.5, lasts_s=3.0)
    """The tracking error."""
    foreign: Watchdog = Watchdog(limit=0.1)
    """Of the setpoints that the vehicle says it follows, those that are not ours."""
    battery_used: Watchdog = Watchdog(limit=0.9, lasts_s=2.0, action=Action.LAND)
    """Share of the charge."""
    estimator: Watchdog = Watchdog(limit=1.0, lasts_s=2.0)
    """The largest of its innovation test ratios, or infinite where it lost a part of its estimate."""
    gps_lost_s: Watchdog = Watchdog(limit=2.0, action=Action.LAND)
    """Since there was a fix in three dimensions, on a vehicle that had one."""
    gps_apart_m: Watchdog = Watchdog(limit=1.2, action=Action.LAND)
    """From the estimate to where GPS has the vehicle; of a receiver that claims n metres, an nth of it."""
    temperature_c: Watchdog = Watchdog(limit=95.0, lasts_s=5.0, action=Action.LAND)
    """Of the companion's processor, where Linux tells it."""

    @field_validator("state_age_s")
    @classmethod
    def _ends_the_flight_at_once(cls, row: Watchdog) -> Watchdog:
        if row.lasts_s > 0.0 or row.action is Action.FALL_BACK:
            raise ValueError(
                "without a state no strategy has anything to go on, so this row takes no lasts_s but 0, "
                "and no action but one that ends the flight: hold, land, return or yield"
            )
        return row

    @model_validator(mode="before")
    @classmethod
    def _complete(cls, given: Any) -> Any:
        """What a row leaves out is as in the row's own default."""
        if not isinstance(given, dict):
            return given
        usual = {name: row.model_dump() for name, row in cls()} if given else {}
        return {
            name: usual[name] | row if name in usual and isinstance(row, dict) else row
            for name, row in given.items()
        }


@dataclass(frozen=True, slots=True)
class Readings:
    """What was read, by the names and in the units of `Watchdogs`; NaN where it is not known."""

    lateness_s: float = math.nan
    computing: float = math.nan
    unpredicted_m: float = math.nan
    off_course_m: float = math.nan
    foreign: float = math.nan
    battery_used: float = math.nan
    estimator: float = math.nan
    gps_lost_s: float = math.nan
    gps_apart_m: float = math.nan
    temperature_c: float = math.nan


_WORDS: Mapping[str, str] = {
    "lateness_s": "the control loop was held up for {:.2g} s",
    "computing": "a control step takes {:.2g} of its period",
    "unpredicted_m": "the tracking error is {:.2g} m from what was predicted",
    "off_course_m": "the vehicle is {:.2g} m from where it should be",
    "foreign": "{:.0%} of the setpoints that the vehicle follows are not ours: does another program send?",
    "battery_used": "{:.0%} of the battery is used",
    "estimator": "the estimator's innovation test ratio is {:.2g}",
    "gps_lost_s": "no GPS fix for {:.2g} s",
    "gps_apart_m": "the estimated position is {:.2g} m from where GPS has the vehicle",
    "temperature_c": "the companion's processor is at {:.0f} °C",
}


class Alarm(NamedTuple):
    """A watchdog that acts.

    Attributes:
        name: of the row.
        value: what was read.
        watchdog: the row.
    """

    name: str
    value: float
    watchdog: Watchdog

    def __str__(self) -> str:
        """In words, with the limit."""
        return f"{_WORDS[self.name].format(self.value)} (watchdog {self.name}, limit {self.watchdog.limit:g})"


Since: TypeAlias = Mapping[str, float]
"""Since when (s) which rows are beyond their limits."""


def watch(watchdogs: Watchdogs, readings: Readings, now_s: float, since: Since) -> tuple[Since, list[Alarm]]:
    """Compare what was read at `now_s` (s) with its limits.

    Args:
        watchdogs: the table.
        readings: what was read.
        now_s: when.
        since: what this returned the last time; empty the first time.

    Returns:
        Since when which rows are beyond their limits, and those that are for so long that they act.
    """
    beyond = {
        name: value for name, value in asdict(readings).items() if value > getattr(watchdogs, name).limit
    }
    still = {name: since.get(name, now_s) for name in beyond}
    alarms = [Alarm(name, value, getattr(watchdogs, name)) for name, value in beyond.items()]
    return still, [alarm for alarm in alarms if now_s - still[alarm.name] >= alarm.watchdog.lasts_s]

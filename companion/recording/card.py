"""The card of a flight log: a JSON file beside it that says what was flown, and in which parts.

`flight.json` belongs to `flight.tlog`, `flight.tlog.xz` and `flight.ulg`. Every key may be missing, keys that
are not known are passed over. Times are Unix seconds on the clock of the machine that recorded.
"""

from pathlib import Path
from typing import Self

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from companion.bounded_file import read_bounded
from companion.errors import InputError

LARGEST_FILE_BYTES = 1_000_000
"""A card of a hundred segments has twenty kilobytes."""


class CardWindow(BaseModel):
    """From one instant to another (Unix seconds)."""

    model_config = ConfigDict(frozen=True)

    start_unix_s: FiniteFloat
    end_unix_s: FiniteFloat

    @model_validator(mode="after")
    def _start_before_end(self) -> Self:
        if self.start_unix_s >= self.end_unix_s:
            raise ValueError("start_unix_s must be before end_unix_s")
        return self


class CardHover(CardWindow):
    """Where the vehicle held one setpoint (NED, m)."""

    setpoint_ned_m: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None = None


class CardSegment(CardWindow):
    """One manoeuvre: its unique `id`, what was flown, what was sent, and the RMS tracking error (m)."""

    id: str
    name: str = ""
    setpoints: str = ""
    rms_m: FiniteFloat | None = None


class Card(BaseModel):
    """What a log is of; `vehicle` and `firmware` as in `config/vehicles/`."""

    model_config = ConfigDict(frozen=True)

    vehicle: str | None = None
    firmware: str | None = None
    autopilot: str = ""
    system_id: int | None = Field(default=None, ge=1, le=255)
    changed_parameters: dict[str, FiniteFloat] = {}
    vehicle_clock_rate: FiniteFloat | None = None
    hover: CardHover | None = None
    segments: tuple[CardSegment, ...] = ()


def log_name(log: Path) -> str:
    """The log's name without its suffixes: `flight` of `flight.tlog.xz`."""
    return Path(log.name.removesuffix(".xz")).stem


def read_card(log: Path) -> Card:
    """The card beside `log`; an empty one where there is none.

    Raises:
        InputError: it cannot be read, or a value is wrong; names the file and the key.
    """
    path = log.with_name(f"{log_name(log)}.json")
    if not path.exists():
        return Card()
    try:
        return Card.model_validate_json(read_bounded(path, LARGEST_FILE_BYTES))
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        key = ".".join(map(str, fault["loc"])) or "the file"
        raise InputError(f"{path}: {key}: {fault['msg']}; correct it or move the file away") from error

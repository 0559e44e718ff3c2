"""What the parameters of PX4 and ArduPilot have in common: a validated value for each name."""

from enum import Enum, auto
from typing import Self

from pydantic import BaseModel, ConfigDict, ValidationError

from sitl.errors import ParameterRefusedError


class Stored(Enum):
    """How a firmware stores a parameter; ArduPilot's whole numbers have their own widths."""

    INT8 = auto()
    INT16 = auto()
    INT32 = auto()
    FLOAT = auto()


class Parameters(BaseModel):
    """One value a parameter; a whole number that is not stored in 32 bits has its `Stored` as annotation."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def changed(self, name: str, value: float) -> Self:
        """A copy in which one parameter has another value.

        Raises:
            ParameterRefusedError: an unknown name, or a value that it may not have.
        """
        try:
            checked = type(self).model_validate({name: value})
        except ValidationError as error:
            raise ParameterRefusedError(f"{name}: {error.errors()[0]['msg']} (got {value!r})") from None
        return self.model_copy(update={name: getattr(checked, name)})

    def stored(self, name: str) -> Stored:
        """How a parameter is stored."""
        if isinstance(getattr(self, name), float):
            return Stored.FLOAT
        metadata = type(self).model_fields[name].metadata
        return next((width for width in metadata if isinstance(width, Stored)), Stored.INT32)

"""Results for programs: JSON that any of them reads."""

import json
import math
from collections.abc import Mapping
from pathlib import Path


def write_result(result: object, file: Path) -> None:
    """Write a result as strict JSON; numbers that are not finite, which it does not have, as null."""
    file.write_text(json.dumps(_strict(result), indent=2, allow_nan=False) + "\n", encoding="utf-8")


def _strict(value: object) -> object:
    match value:
        case float() if not math.isfinite(value):
            return None
        case Mapping():
            return {key: _strict(each) for key, each in value.items()}
        case list() | tuple():
            return [_strict(each) for each in value]
        case _:
            return value

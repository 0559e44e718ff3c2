"""The guard's limits from a YAML file, such as `config/guard.yaml`, which describes the keys."""

from pathlib import Path

import yaml
from pydantic import ValidationError

from companion.errors import InputError
from companion.flight.guard import GuardLimits


def read_guard_limits(path: Path) -> GuardLimits:
    """The limits in `path`; keys that it leaves out keep their defaults.

    Raises:
        InputError: it cannot be read, or a value is wrong; names the file, the key and what is expected.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    try:
        return GuardLimits.model_validate({} if content is None else content)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        key = ".".join(map(str, fault["loc"])) or "the file"
        if fault["type"] == "extra_forbidden":
            raise InputError(
                f"{path}: {key}: no such key; config/guard.yaml shows those there are"
            ) from error
        raise InputError(f"{path}: {key}: {fault['msg']}, got {fault['input']!r}") from error

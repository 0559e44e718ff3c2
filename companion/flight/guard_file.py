"""The guard's limits from a YAML file, such as `config/guard.yaml`, which describes the keys."""

import reprlib
from pathlib import Path

import yaml
from pydantic import ValidationError

from companion.bounded_file import read_bounded
from companion.errors import InputError
from companion.flight.guard import GuardLimits

LARGEST_FILE_BYTES = 100_000
"""The file that ships has two kilobytes."""


class _Loader(yaml.SafeLoader):
    """Plain YAML without aliases, with which a file of a kilobyte can mean gigabytes."""

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("aliases (*name) are not taken: write the value out")
        return super().compose_node(parent, index)


def read_guard_limits(path: Path) -> GuardLimits:
    """The limits in `path`; keys that it leaves out keep their defaults.

    Raises:
        InputError: it cannot be read, or a value is wrong; names the file, the key and what is expected.
    """
    try:
        content = yaml.load(read_bounded(path, LARGEST_FILE_BYTES).decode(), _Loader)
    except RecursionError as error:
        raise InputError(f"{path}: brackets within brackets, too deep to be read") from error
    except (yaml.YAMLError, ValueError) as error:  # dates and numbers that are none, too
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
        raise InputError(f"{path}: {key}: {fault['msg']}, got {reprlib.repr(fault['input'])}") from error

"""Settings that users write: plain YAML, checked key by key against a model that says what may be in it."""

import reprlib
from pathlib import Path
from typing import TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from companion.bounded_file import read_bounded
from companion.errors import InputError

LARGEST_FILE_BYTES = 100_000
"""Those that ship have a few kilobytes."""

ModelT = TypeVar("ModelT", bound=BaseModel)


class _Loader(yaml.SafeLoader):
    """Plain YAML without aliases, with which a file of a kilobyte can mean gigabytes."""

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("aliases (*name) are not taken: write the value out")
        return super().compose_node(parent, index)


def read_settings(path: Path, defaults: ModelT, shown_in: str) -> ModelT:
    """`defaults`, but for the keys that the file has; the whole of such a key is the file's.

    Args:
        path: the file.
        defaults: what holds for keys that it leaves out.
        shown_in: the file that ships and shows all keys.

    Raises:
        InputError: it cannot be read, or a value is wrong; names the file, the key and what is expected.
    """
    try:
        content = yaml.load(read_bounded(path, LARGEST_FILE_BYTES).decode(), _Loader)
    except RecursionError as error:
        raise InputError(f"{path}: brackets within brackets, too deep to be read") from error
    except (yaml.YAMLError, ValueError) as error:  # dates and numbers that are none, too
        raise InputError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    if content is None:
        return defaults
    if not isinstance(content, dict):
        raise InputError(f"{path}: expected `key: value` lines, as in {shown_in}")
    try:
        return type(defaults).model_validate(defaults.model_dump() | content)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        key = ".".join(map(str, fault["loc"])) or "the file"
        if fault["type"] == "extra_forbidden":
            raise InputError(f"{path}: {key}: no such key; {shown_in} shows those there are") from error
        raise InputError(f"{path}: {key}: {fault['msg']}, got {reprlib.repr(fault['input'])}") from error

"""Settings that users write: plain YAML, checked key by key against a model that says what may be in it."""

import reprlib
from collections import Counter
from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from companion.bounded_file import read_bounded
from companion.errors import InputError

LARGEST_FILE_BYTES = 100_000
"""Those that ship have a few kilobytes."""

ModelT = TypeVar("ModelT", bound=BaseModel)


class _Loader(yaml.SafeLoader):
    """Plain YAML, no key of it given twice, without aliases, with which a kilobyte can mean gigabytes."""

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("aliases (*name) are not taken: write the value out")
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        for key, count in Counter(str(key.value) for key, _ in node.value).items():
            if count > 1:
                raise yaml.YAMLError(f"{key} is given twice")
        return super().construct_mapping(node, deep)


def read_settings(path: Path, defaults: ModelT, shown_in: str) -> ModelT:
    """`defaults`, but for the keys that the file has.

    Of a section, too, what it leaves out keeps its default, unless it is a section of another kind.

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
        return type(defaults).model_validate(_completed(content, defaults))
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        key = ".".join(map(str, fault["loc"])) or "the file"
        if fault["type"] == "extra_forbidden":
            raise InputError(f"{path}: {key}: no such key; {shown_in} shows those there are") from error
        raise InputError(f"{path}: {key}: {fault['msg']}, got {reprlib.repr(fault['input'])}") from error


def _completed(content: Mapping[str, Any], defaults: BaseModel) -> dict[str, Any]:
    """The content, and of the defaults what is not in it."""
    completed = {key: getattr(defaults, key) for key in type(defaults).model_fields} | dict(content)
    for key, section in content.items():
        default = getattr(defaults, key, None)
        if isinstance(default, BaseModel) and isinstance(section, dict) and _is_of_its_kind(section, default):
            completed[key] = _completed(section, default)
    return completed


def _is_of_its_kind(section: Mapping[str, Any], default: BaseModel) -> bool:
    """Whether the section has no key but the default's, and is of the kind that it names, if it names one."""
    fields = type(default).model_fields
    return set(section) <= set(fields) and section.get("kind", None) in (None, getattr(default, "kind", None))

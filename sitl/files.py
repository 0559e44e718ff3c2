"""Configuration files: where they are, and how one becomes a validated model."""

import reprlib
from collections import Counter
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from sitl.errors import ConfigError

ModelT = TypeVar("ModelT", bound=BaseModel)

LARGEST_FILE_BYTES = 100_000
"""No configuration file may be larger; those that ship have a few kilobytes."""

_SUFFIXES = (".yaml", ".yml")


class KeyFaultError(ValueError):
    """What a model's validator raises about one of its keys after comparing several."""

    def __init__(self, key: str, reason: str) -> None:
        super().__init__(f"{key}: {reason}")
        self.key = key
        self.reason = reason


def config_directory() -> Path:
    """`config/` inside the installed package, or the repository's when run from its tree."""
    package = Path(__file__).parent
    installed = package / "config"
    return installed if installed.is_dir() else package.parent / "config"


def known_names(kind: str) -> list[str]:
    """Names of the files that ship in `config/<kind>/`, sorted."""
    return sorted(path.stem for path in (config_directory() / kind).glob("*.yaml"))


def find(kind: str, name_or_path: str | Path) -> Path:
    """The file of a shipped name ("bebop2") or of a path ("./mine.yaml").

    Raises:
        ConfigError: neither exists; the message lists the known names.
    """
    path = Path(name_or_path).expanduser()
    if path.suffix not in _SUFFIXES and path.name == str(name_or_path):
        path = config_directory() / kind / f"{name_or_path}.yaml"
    if not path.is_file():
        raise ConfigError(
            name_or_path, "", f"no such file or name; known {kind}: {', '.join(known_names(kind))}"
        )
    return path


def load(model: type[ModelT], kind: str, name_or_path: str | Path) -> ModelT:
    """Read a YAML file into `model`; its `name` is the file's stem unless the file gives one.

    Raises:
        ConfigError: not found, not YAML, or refused by the model, with the first key at fault.
    """
    path = find(kind, name_or_path)
    try:
        return model.model_validate({"name": path.stem} | _mapping(path))
    except ValidationError as error:
        raise ConfigError(path, *_first_fault(error)) from None


class _Loader(yaml.SafeLoader):
    """Plain YAML in which a key may not be given twice, and nothing refers to what is elsewhere in it.

    With aliases, a file of a kilobyte can mean gigabytes.
    """

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("aliases (*name) are not taken: write the value out")
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        for key, count in Counter(str(key.value) for key, _ in node.value).items():
            if count > 1:
                raise KeyFaultError(key, "given twice")
        return super().construct_mapping(node, deep)


def _mapping(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as file:
            text = file.read(LARGEST_FILE_BYTES + 1)
        if len(text) > LARGEST_FILE_BYTES:
            raise ConfigError(path, "", f"larger than {LARGEST_FILE_BYTES} bytes")
        content = yaml.load(text.decode(), _Loader)
    except KeyFaultError as fault:
        raise ConfigError(path, fault.key, fault.reason) from None
    except OSError as error:
        raise ConfigError(path, "", error.strerror or str(error)) from None
    except RecursionError:
        raise ConfigError(path, "", "brackets within brackets within brackets, too deep to be read") from None
    except (yaml.YAMLError, ValueError) as error:  # dates and numbers that are none, too
        raise ConfigError(path, "", f"not readable as YAML: {' '.join(str(error).split())}") from None
    if not isinstance(content, dict):
        raise ConfigError(path, "", "expected `key: value` lines")
    return content


def _first_fault(error: ValidationError) -> tuple[str, str]:
    """Dotted key and reason of the first complaint; a value that was given is quoted."""
    fault = error.errors(include_url=False)[0]
    cause = fault.get("ctx", {}).get("error")
    if isinstance(cause, KeyFaultError):
        return ".".join((*map(str, fault["loc"]), cause.key)), cause.reason
    key = ".".join(str(part) for part in fault["loc"])
    if fault["type"] == "extra_forbidden":
        return key, "unknown key; see docs for the keys that exist"
    if fault["type"] == "missing":
        return key, "missing; this value has no default"
    return key, f"{fault['msg']} (got {reprlib.repr(fault['input'])})"

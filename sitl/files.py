"""Configuration files: where they are, and how one becomes a validated model."""

from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from sitl.errors import ConfigError

ModelT = TypeVar("ModelT", bound=BaseModel)

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
    """Plain YAML in which a key may not be given twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [str(key.value) for key, _ in node.value]
        for key in keys:
            if keys.count(key) > 1:
                raise KeyFaultError(key, "given twice")
        return super().construct_mapping(node, deep)


def _mapping(path: Path) -> dict[str, Any]:
    try:
        content = yaml.load(path.read_text(encoding="utf-8"), _Loader)
    except KeyFaultError as fault:
        raise ConfigError(path, fault.key, fault.reason) from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ConfigError(path, "", f"not readable as YAML: {' '.join(str(error).split())}") from None
    except OSError as error:
        raise ConfigError(path, "", error.strerror or str(error)) from None
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
    return key, f"{fault['msg']} (got {fault['input']!r})"

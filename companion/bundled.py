"""The files that ship with the program: models and trajectories, by name."""

from pathlib import Path

from companion.errors import InputError


def config_directory() -> Path:
    """`config/` inside the installed package, or the repository's when run from its tree."""
    package = Path(__file__).parent
    installed = package / "config"
    return installed if installed.is_dir() else package.parent / "config"


def find(kind: str, name_or_path: str | Path, suffix: str) -> Path:
    """The file of a shipped name ("ardrone2") or of a path ("./mine.safetensors").

    Raises:
        InputError: neither exists; the message lists the known names.
    """
    path = Path(name_or_path).expanduser()
    shipped = config_directory() / kind / f"{name_or_path}{suffix}"
    if path.is_file():
        return path
    if path.name == str(name_or_path) and shipped.is_file():
        return shipped
    known = ", ".join(sorted(file.stem for file in shipped.parent.glob(f"*{suffix}"))) or "none"
    raise InputError(f"{name_or_path}: no such file, and no name in config/{kind} (known: {known})")

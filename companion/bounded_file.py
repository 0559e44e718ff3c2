"""The bytes of a file that a user names, and never more than a file of its kind may have."""

from pathlib import Path

from companion.errors import InputError


def read_bounded(path: Path, largest: int) -> bytes:
    """The content of `path`.

    Raises:
        InputError: it cannot be read, or is larger than `largest` (bytes).
    """
    try:
        with path.open("rb") as file:
            content = file.read(largest + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    if len(content) > largest:
        raise InputError(f"{path}: larger than {largest / 1e6:g} MB, which no file of its kind is")
    return content

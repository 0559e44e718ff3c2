"""The bytes of a file that a user names, packed with xz or not, and never more than can be held."""

import lzma
import os
from pathlib import Path

from companion.errors import InputError

MAX_BYTES = 2**30
"""No recording may be larger, packed or unpacked (bytes): three hours at the usual rates."""


def too_large(path: Path) -> InputError:
    """What to raise about a file that is larger than `MAX_BYTES`, packed or unpacked."""
    return InputError(f"{path}: larger than {MAX_BYTES} bytes: too large for one recording")


def read_bytes(path: Path) -> bytes:
    """The content of `path`; of `.xz` files what is packed in them, as far as they go where they were cut.

    Raises:
        InputError: it cannot be read, is larger than `MAX_BYTES`, or is damaged where it is packed.
    """
    try:
        with path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            if size > MAX_BYTES:
                raise too_large(path)
            content = file.read(size)  # a device, which has no end, has no size either
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    return _unpacked(content, path) if path.suffix.lower() == ".xz" else content


def _unpacked(packed: bytes, path: Path) -> bytes:
    content = b""
    try:
        while packed:  # a stream after another: xz files may be joined
            stream = lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=MAX_BYTES)
            content += stream.decompress(packed, MAX_BYTES + 1 - len(content))
            if len(content) > MAX_BYTES:
                raise too_large(path)
            packed = stream.unused_data
    except lzma.LZMAError as error:
        raise InputError(f"{path}: damaged, or not packed with xz ({error}): copy it anew") from error
    return content

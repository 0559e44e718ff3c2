"""The file that holds the key of signed links."""

import base64
import binascii
import hashlib
import os
import re
import stat
from pathlib import Path

from companion.errors import InputError
from companion.link.signing import SigningKey

HOW_TO_MAKE_ONE = "make one with `(umask 077; openssl rand -hex 32 > FILE)`"
_HEX = re.compile(r"[0-9A-Fa-f]{64}")
_BASE64 = re.compile(r"[0-9A-Za-z+/]{43}=")
_LARGEST_FILE = 4096


def read_signing_key(path: Path) -> SigningKey:
    """The key in the file at `path`, which only its owner may read.

    It has one line: 32 bytes as 64 hexadecimal digits or as base64, or else a passphrase, whose SHA-256 is
    the key (as in MAVProxy and QGroundControl).

    Raises:
        InputError: there is no such file, others may read it, or it holds no key.
    """
    try:
        with path.open("rb") as file:
            mode = os.fstat(file.fileno()).st_mode
            content = file.read(_LARGEST_FILE + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; {HOW_TO_MAKE_ONE}") from error
    if stat.S_IMODE(mode) & 0o077:
        raise InputError(f"{path}: others may read this key: make it your own with `chmod 600 {path}`")
    if len(content) > _LARGEST_FILE:
        raise InputError(f"{path}: this is no key file, it is too long; {HOW_TO_MAKE_ONE}")
    try:
        lines = content.decode().splitlines()
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: this is no key file, it holds no text; {HOW_TO_MAKE_ONE}") from error
    if len(lines) != 1 or not lines[0].strip():
        raise InputError(f"{path}: a key file has one line, not {len(lines)}; {HOW_TO_MAKE_ONE}")
    return SigningKey(_secret(lines[0].strip()))


def _secret(line: str) -> bytes:
    if _HEX.fullmatch(line):
        return binascii.unhexlify(line)
    if _BASE64.fullmatch(line):
        return base64.b64decode(line)
    return hashlib.sha256(line.encode()).digest()

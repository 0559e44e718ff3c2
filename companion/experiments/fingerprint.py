"""What the result of a job depends on, as one number: what it is given, and the program itself."""

import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import companion
import sitl

_PACKAGES = (companion, sitl)
_WITHOUT = "cli"
"""The room of `companion` that no flight passes through."""


def fingerprint(given: Iterable[bytes]) -> str:
    """SHA-256 (hex) of what is given to the program, and of the sources of both packages."""
    sha = hashlib.sha256(_program())
    for part in given:
        sha.update(b"%d " % len(part) + part)
    return sha.hexdigest()


@cache
def _program() -> bytes:
    sha = hashlib.sha256()
    for root in (Path(package.__path__[0]) for package in _PACKAGES):
        for file in sorted(root.rglob("*.py")):
            if file.relative_to(root).parts[0] != _WITHOUT:
                sha.update(file.read_bytes())
    return sha.digest()

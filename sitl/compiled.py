"""The one place where functions are handed to numba.

Kernels are ordinary typed functions over arrays, floats and named tuples of both. No fastmath: the same
input must give the same bits. Arrays are filled element by element where a kernel is compiled at start:
assigning an array to a slice makes numba compile the text of its shape errors too, which takes seconds.
"""

import hashlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar, cast

import numba
import platformdirs

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` at its first call; the machine code is kept between runs."""
    return cast("Callable[P, R]", numba.njit(cache=True, error_model="numpy")(function))


def _cache_directory() -> Path:
    """A directory for exactly these kernels.

    numba notices a change in a function's own file only, not in the files of the functions it calls,
    so the directory is named after the sources of all kernels.
    """
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        text = source.read_bytes()
        if b"@compiled" in text:
            digest.update(text)
    base = os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_dir("impromptu", appauthor=False)
    directory = Path(base) / "kernels" / digest.hexdigest()[:16]
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError:  # no home that can be written to: containers, services
        directory = Path(tempfile.mkdtemp(prefix="impromptu-kernels-"))
    return directory


vars(numba.config)["CACHE_DIR"] = str(_cache_directory())

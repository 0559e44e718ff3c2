"""Timestamps of signatures that outlive the program, so that nothing signed before is ever believed again.

They are in a small file of each key's own. While the program runs, the file is ahead of what was sent: one
that dies without a word begins behind it.
"""

import asyncio
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from companion.bounded_file import read_bounded
from companion.errors import InputError
from companion.link.signing import (
    LARGEST_STREAMS,
    LAST_TIMESTAMP,
    TICKS_PER_S,
    Signer,
    SigningKey,
    Stream,
    ticks_since_2015,
)
from companion.link.tasks import background_tasks

_LARGEST_FILE_BYTES = 1_000_000
_SAVE_INTERVAL_S = 2.0
_AHEAD = 5 * TICKS_PER_S

_Timestamp = Annotated[int, Field(ge=0, le=LAST_TIMESTAMP)]
_Id = Annotated[int, Field(ge=0, le=255)]


class _State(BaseModel):
    """What the file holds."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    timestamp: _Timestamp = 0
    streams: Annotated[tuple[tuple[_Id, _Id, _Id, _Timestamp], ...], Field(max_length=LARGEST_STREAMS)] = ()


def state_file(key: SigningKey) -> Path:
    """Where the timestamps of `key` are: under `$XDG_STATE_HOME`, or else `~/.local/state`."""
    base = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(base) / "impromptu" / "signing" / f"{key.fingerprint}.json"


@asynccontextmanager
async def lasting_signer(key: SigningKey) -> AsyncIterator[Signer]:
    """A signer that goes on where the last one with `key` stopped; its timestamps are kept.

    Raises:
        InputError: the state file is broken, or cannot be written.
    """
    path = state_file(key)
    state = await asyncio.to_thread(_read, path)
    now = ticks_since_2015()
    streams: dict[Stream, int] = {
        (system, component, link): t for system, component, link, t in state.streams
    }
    signer = Signer(key, now, max(state.timestamp, now()), streams)
    await asyncio.to_thread(_write, path, _state(signer, _AHEAD))
    try:
        async with background_tasks() as spawn:
            spawn(_keep(signer, path))
            yield signer
    finally:
        with suppress(InputError):  # what is in the file is ahead, and good enough
            await asyncio.to_thread(_write, path, _state(signer))


async def _keep(signer: Signer, path: Path) -> None:
    while True:
        await asyncio.sleep(_SAVE_INTERVAL_S)
        with suppress(InputError):  # a disk that fills up in flight ends no flight
            await asyncio.to_thread(_write, path, _state(signer, _AHEAD))


def _state(signer: Signer, ahead: int = 0) -> _State:
    streams = tuple((*stream, timestamp) for stream, timestamp in signer.streams.items())
    return _State(timestamp=min(signer.timestamp + ahead, LAST_TIMESTAMP), streams=streams)


def _read(path: Path) -> _State:
    if not path.exists():
        return _State()
    try:
        return _State.model_validate_json(read_bounded(path, _LARGEST_FILE_BYTES))
    except ValidationError as error:
        raise InputError(
            f"{path}: these are no timestamps of signatures; remove it to begin at this machine's time"
        ) from error


def _write(path: Path, state: _State) -> None:
    draft = path.with_suffix(f".{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with draft.open("w") as file:
            file.write(state.model_dump_json())
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
    except OSError as error:
        raise InputError(f"{path}: the timestamps of signatures cannot be kept: {error.strerror}") from error

"""The command as processes of their own, and what they say."""

import asyncio
import sys
from asyncio.subprocess import PIPE, STDOUT, Process
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager


@asynccontextmanager
async def companion(*arguments: str) -> AsyncIterator[Process]:
    """`companion` with these arguments; it is killed where it has not ended by itself."""
    program = "from companion.cli import main; main()"
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-c", program, *arguments, stdout=PIPE, stderr=STDOUT
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


async def line_with(text: str, process: Process) -> str:
    """The next line that holds `text`."""
    assert process.stdout is not None
    said = ""
    while line := (await process.stdout.readline()).decode():
        if text in line:
            return line
        said += line
    raise AssertionError(f"it ended without saying {text!r}, but this: {said}")

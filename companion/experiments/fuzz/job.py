"""All blocks of the benchmark, in an order that does not change."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from companion.experiments.backend import LOCAL, Backend
from companion.experiments.fingerprint import fingerprint
from companion.experiments.fuzz.files import READERS, fuzz_files
from companion.experiments.fuzz.link import VEHICLES, fuzz_link
from companion.experiments.fuzz.row import FuzzRow
from companion.experiments.fuzz.samples import samples
from companion.experiments.simulated_flights import prepare_simulator

_LINK_BLOCK = 100_000
_FILE_BLOCK = 1_000
_MOST_BLOCKS = 1_000_000


@dataclass(frozen=True)
class Block:
    """So many inputs to one reader, all from one seed.

    Attributes:
        reader: in `READERS`; None for the two ends of a link.
        samples: files that are right, for a reader of files.
        seed: of everything random.
        inputs: how many.
    """

    reader: str | None
    samples: Sequence[bytes]
    seed: int
    inputs: int


def blocks(frames: int, files: int, seed: int) -> list[Block]:
    """So many mutated frames and pieces of noise, and so many files of each kind; simulates one flight."""
    sizes = enumerate(_sizes(frames, _LINK_BLOCK))
    return [
        *(Block(None, (), _MOST_BLOCKS * seed + number, size) for number, size in sizes),
        *_file_blocks(files, seed, samples() if files else {}),
    ]


def _file_blocks(files: int, seed: int, right: Mapping[str, Sequence[bytes]]) -> Iterator[Block]:
    for name in READERS:
        for number, size in enumerate(_sizes(files, _FILE_BLOCK)):
            yield Block(name, right[name], _MOST_BLOCKS * seed + number, size)


def _sizes(total: int, largest: int) -> Iterator[int]:
    for begun in range(0, total, largest):
        yield min(largest, total - begun)


def belongs_to(todo: Sequence[Block]) -> str:
    """The same only for blocks that give the same rows."""
    return fingerprint(f"{block.reader} {block.seed} {block.inputs}".encode() for block in todo)


def prepare() -> None:
    """Compile the simulator, once for all cores."""
    prepare_simulator(VEHICLES, "ideal")


def fuzz_block(block: Block) -> FuzzRow:
    """What came of it."""
    if block.reader is None:
        return fuzz_link(block.seed, block.inputs)
    return fuzz_files(block.reader, block.samples, block.seed, block.inputs)


def run(todo: Sequence[Block], backend: Backend = LOCAL) -> Iterator[FuzzRow]:
    """The rows of the blocks, in their order, as they end."""
    return backend.each(fuzz_block, todo)

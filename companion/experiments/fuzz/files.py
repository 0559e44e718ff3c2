"""Mutated files, each to its reader: it is read, or refused with one of our own errors."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from companion import clock
from companion.errors import ImpromptuError
from companion.experiments.fuzz.hang import HangError, ended_after
from companion.experiments.fuzz.mutation import BYTES, TEXT, Mutation, mutated
from companion.experiments.fuzz.row import FuzzRow, described, some
from companion.experiments.memory import resident_bytes
from companion.flight.guard_file import read_guard_limits
from companion.flight.recorded_inputs import recorded_inputs
from companion.learning.model_file import load_model
from companion.link.parameter_file import read_parameter_file
from companion.link.signing_key import read_signing_key
from companion.mission.files import read_plan
from companion.recording.card import read_card
from companion.recording.files import read_recording
from companion.trajectory import Limits, Placement, read_trajectory
from sitl.conditions import load_conditions
from sitl.errors import SitlError
from sitl.faults.reading import load_faults
from sitl.vehicle import load_vehicle

LONGEST_S = 10.0
"""No file may take more of the processor (s)."""


class Reader(NamedTuple):
    """What reads files of one kind.

    Attributes:
        read: from a path.
        suffix: of the path.
        mutations: in which its files are made wrong.
    """

    read: Callable[[Path], object]
    suffix: str
    mutations: Sequence[Mutation] = BYTES


READERS: Mapping[str, Reader] = {
    "csv": Reader(lambda path: read_trajectory(path, Placement(), Limits()), ".csv", TEXT),
    "plan": Reader(read_plan, ".plan", TEXT),
    "waypoints": Reader(read_plan, ".waypoints", TEXT),
    "vehicle": Reader(load_vehicle, ".yaml", TEXT),
    "conditions": Reader(load_conditions, ".yaml", TEXT),
    "faults": Reader(load_faults, ".yaml", TEXT),
    "guard": Reader(read_guard_limits, ".yaml", TEXT),
    "model": Reader(load_model, ".safetensors", (*BYTES, *TEXT)),
    "recording": Reader(read_recording, ".mcap", (*BYTES, *TEXT)),
    "replay": Reader(lambda path: list(recorded_inputs(path)), ".mcap", (*BYTES, *TEXT)),
    "tlog": Reader(read_recording, ".tlog"),
    "card": Reader(lambda path: read_card(path.with_suffix(".tlog")), ".json", TEXT),
    "ulog": Reader(read_recording, ".ulg"),
    "parameters": Reader(read_parameter_file, ".params", TEXT),
    "signing key": Reader(read_signing_key, ".key", TEXT),
}


def fuzz_files(name: str, samples: Sequence[bytes], seed: int, inputs: int) -> FuzzRow:
    """Give so many mutations of right files to one of the `READERS`; the same seed, the same files."""
    rng = np.random.default_rng(seed)
    reader = READERS[name]
    faults: list[str] = []
    refused, slowest_s, half_bytes = 0, 0.0, 0
    begun_s = clock.stopwatch_s()
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"mutated{reader.suffix}"
        path.touch(0o600)
        for place in range(inputs):
            if place == inputs // 2:
                half_bytes = resident_bytes()
            path.write_bytes(mutated(samples[int(rng.integers(len(samples)))], reader.mutations, rng))
            input_s = clock.processor_s()
            try:
                with ended_after(LONGEST_S):
                    reader.read(path)
            except (ImpromptuError, SitlError):
                refused += 1
            except (Exception, HangError) as error:
                faults.append(described(error))
            slowest_s = max(slowest_s, clock.processor_s() - input_s)
    return FuzzRow(
        reader=name,
        inputs=inputs,
        refused=refused,
        faults=some(faults),
        slowest_s=slowest_s,
        grown_bytes=resident_bytes() - half_bytes,
        wall_s=clock.stopwatch_s() - begun_s,
    )

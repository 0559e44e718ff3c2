"""A library of networks: the inverses of several vehicles, of which a flight takes whichever helps."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from companion.errors import InputError
from companion.learning.inverse_network import InverseNetwork
from companion.learning.model_file import load_model

AUTO = "auto"
"""Means all networks that ship, where one may be named."""


@dataclass(frozen=True, eq=False)
class Library:
    """Networks by their names, in the order of these."""

    networks: Mapping[str, InverseNetwork]

    def without(self, name: str) -> "Library":
        """All but one: a vehicle's own, where it is to fly with those of others."""
        return Library({each: network for each, network in self.networks.items() if each != name})


def library_files(directory: Path) -> list[Path]:
    """The model files in a directory, by name."""
    return sorted(directory.glob("*.safetensors"))


def load_library(directory: Path, sample_time_s: float) -> Library:
    """All networks of a directory that were trained for this time between two setpoints (s).

    Raises:
        InputError: there is none, or a file is damaged.
    """
    networks = {file.stem: load_model(file) for file in library_files(directory)}
    fitting = {
        name: network for name, network in networks.items() if network.card.sample_time_s == sample_time_s
    }
    if not fitting:
        raise InputError(
            f"{directory}: no network for setpoints every {sample_time_s:g} s; name one by --model"
        )
    return Library(fitting)

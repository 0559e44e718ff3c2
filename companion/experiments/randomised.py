"""A vehicle as uncertain as it is known: mass, drag and delay drawn at random about its file's.

A network that learned from several such vehicles leans less on what is peculiar to one (domain randomisation:
Peng et al., "Sim-to-real transfer of robotic control with dynamics randomization", ICRA 2018).
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import yaml

from companion.experiments.twin import twin_vehicle
from companion.experiments.vehicle_parameters import with_values
from sitl.vehicle import Vehicle

DELAY_S = 0.1
"""Most that a spread of 1 adds to the delay of the rotors."""


class Variation(NamedTuple):
    """How a vehicle differs from its file.

    Attributes:
        mass, drag: factors; the drag's is of hull and rotors alike.
        delay_s: on top of the rotors' own (s).
    """

    mass: float
    drag: float
    delay_s: float


def drawn(spread: float, rng: np.random.Generator) -> Variation:
    """Mass and drag within 1 ± `spread`, and a delay of at most `spread` · `DELAY_S`, all uniform."""
    mass, drag = rng.uniform(1.0 - spread, 1.0 + spread, 2).tolist()
    return Variation(mass, drag, float(rng.uniform(0.0, spread * DELAY_S)))


def varied(vehicle: Vehicle, variation: Variation) -> Vehicle:
    """The vehicle so varied; whatever its file leaves to be tuned to the airframe is tuned anew.

    Raises:
        InputError: it could not fly.
    """
    hull = vehicle.body_drag
    values = {
        "mass_kg": variation.mass * vehicle.mass_kg,
        "rotors.drag_coefficient_n_s2_per_m": variation.drag * vehicle.rotor_drag_n_s2_per_m,
        "rotors.delay_s": vehicle.rotors.delay_s + variation.delay_s,
        "body_drag.linear_n_s_per_m": variation.drag * float(np.mean(hull.linear_n_s_per_m)),
        "body_drag.quadratic_n_s2_per_m2": variation.drag * float(np.mean(hull.quadratic_n_s2_per_m2)),
    }
    return with_values(vehicle, values)


@contextmanager
def varied_file(name_or_path: str, variation: Variation) -> Iterator[Path]:
    """A file of that vehicle so varied, for as long as it is flown.

    Raises:
        InputError: no such vehicle, or it could not fly.
    """
    vehicle = varied(twin_vehicle(name_or_path), variation)
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"{vehicle.name}.yaml"
        path.write_text(yaml.safe_dump(vehicle.model_dump(mode="json", exclude_unset=True)))
        yield path

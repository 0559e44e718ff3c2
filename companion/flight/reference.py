"""What is sent to the autopilot at one control step: u = u1 + u2 (paper, Eqn. referenceCommand)."""

from dataclasses import dataclass, field

import numpy as np

from companion.arrays import Vec3


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A setpoint for the autopilot's position controller, NED.

    Attributes:
        position: m. velocity: m/s.
        acceleration: m/s², or None where none is sent.
    """

    position: Vec3
    velocity: Vec3
    acceleration: Vec3 | None = None

    def is_finite(self) -> bool:
        """Whether every number that would be sent is finite."""
        parts = (self.position, self.velocity, *(() if self.acceleration is None else (self.acceleration,)))
        return all(bool(np.isfinite(part).all()) for part in parts)

    def corrected(self, correction: "Correction") -> "Reference":
        """The reference with the correction added; a feed-forward acceleration stays as it is."""
        return Reference(
            self.position + correction.position, self.velocity + correction.velocity, self.acceleration
        )


def _zero() -> Vec3:
    return np.zeros(3)


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """What the online model adds to a reference: u2, NED.

    Attributes:
        position: m. velocity: m/s.
    """

    position: Vec3 = field(default_factory=_zero)
    velocity: Vec3 = field(default_factory=_zero)

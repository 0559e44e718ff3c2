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

    @property
    def _feedforward(self) -> Vec3:
        return np.zeros(3) if self.acceleration is None else self.acceleration

    def towards(self, other: "Reference", share: float) -> "Reference":
        """`share` (0 to 1) of the way to another one; an acceleration that only one has counts in part."""
        from_a, to_a = self._feedforward, other._feedforward
        return Reference(
            self.position + share * (other.position - self.position),
            self.velocity + share * (other.velocity - self.velocity),
            from_a + share * (to_a - from_a),
        )

    def pull_towards(self, other: "Reference", stiffness_1_s2: Vec3, damping_1_s: Vec3) -> Vec3:
        """How much more the other accelerates a vehicle with this position loop (m/s²)."""
        moved = Correction(other.position - self.position, other.velocity - self.velocity)
        return moved.pull(stiffness_1_s2, damping_1_s) + other._feedforward - self._feedforward

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

    def scaled(self, share: float) -> "Correction":
        """`share` of it."""
        return Correction(share * self.position, share * self.velocity)

    def pull(self, stiffness_1_s2: Vec3, damping_1_s: Vec3) -> Vec3:
        """The acceleration that it makes of a vehicle with this position loop (m/s²)."""
        return stiffness_1_s2 * self.position + damping_1_s * self.velocity

"""The strategies: how the reference u1 is made from the trajectory, and whether an online model corrects it.

| strategy      | u1                                                    | u2                |
|---------------|-------------------------------------------------------|-------------------|
| `baseline`    | position and velocity                                 | none              |
| `feedforward` | position, velocity and acceleration                   | none              |
| `lookahead`   | position and velocity, a constant time early          | none              |
| `dnn`         | inverse network of a source vehicle                   | none              |
| `gp`          | position, velocity and acceleration                   | online correction |
| `dnn+gp`      | the same, or part of the way to it from `gp`'s        | online correction |
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from companion.errors import InputError
from companion.flight.preview import desired_ahead, state_of
from companion.flight.reference import Reference
from companion.learning.features import inverse_inputs, reference
from companion.learning.inverse_network import InverseNetwork
from companion.learning.online_settings import OnlineSettings
from companion.state import VehicleState
from companion.trajectory.trajectory import Trajectory

_PLAIN_PERIOD_S = 0.02


class Strategy(StrEnum):
    """By the names that the command takes."""

    BASELINE = "baseline"
    FEEDFORWARD = "feedforward"
    LOOKAHEAD = "lookahead"
    DNN = "dnn"
    GP = "gp"
    DNN_GP = "dnn+gp"

    @property
    def learns_online(self) -> bool:
        """Whether an online model corrects u1."""
        return self in (Strategy.GP, Strategy.DNN_GP)

    def period_s(self, settings: OnlineSettings) -> float:
        """Time between two setpoints (s): what was learned at a sample time is flown at it."""
        is_learned = self is Strategy.DNN or self.learns_online
        return settings.sample_time_s if is_learned else _PLAIN_PERIOD_S


class ReferenceLaw(Protocol):
    """How u1 is made: from the trajectory, the time on it (s) and the vehicle's state."""

    def __call__(self, trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        """The reference for this control step."""
        ...


def position_velocity(trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
    """The baseline: the trajectory's position and velocity now."""
    desired = trajectory.at(time_s)
    return Reference(desired.position, desired.velocity)


def position_velocity_acceleration(trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
    """The baseline with the trajectory's acceleration as feed-forward."""
    desired = trajectory.at(time_s)
    return Reference(desired.position, desired.velocity, desired.acceleration)


@dataclass(frozen=True, slots=True)
class Lookahead:
    """The baseline, `shift_s` seconds early: what compensates a vehicle's constant lag."""

    shift_s: float

    def __call__(self, trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        """The trajectory's position and velocity `shift_s` from now."""
        return position_velocity(trajectory, time_s + self.shift_s, state)


@dataclass(frozen=True, slots=True)
class InverseDynamics:
    """u1 of the paper: the source vehicle's inverse network, asked for what the trajectory needs next."""

    network: InverseNetwork

    def __call__(self, trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        """The reference that would bring the source vehicle onto the trajectory (Eqn. dnnMapping)."""
        x = state_of(state)
        outputs = self.network(
            inverse_inputs(x, *desired_ahead(trajectory, time_s, self.network.card.preview))
        )
        return Reference(*reference(x, outputs))


@dataclass(frozen=True, slots=True)
class Tempered:
    """Between what is plain and what a law makes of it: only `share` of the way (0 to 1) to the law's."""

    law: ReferenceLaw
    share: float

    def __call__(self, trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        """The mean of both references, so weighted; acceleration is fed forward as far as it is plain."""
        plain, other = trajectory.at(time_s), self.law(trajectory, time_s, state)
        return Reference(
            plain.position + self.share * (other.position - plain.position),
            plain.velocity + self.share * (other.velocity - plain.velocity),
            (1.0 - self.share) * plain.acceleration,
        )


def reference_law(
    strategy: Strategy,
    *,
    network: InverseNetwork | None = None,
    lookahead_s: float | None = None,
    network_share: float = 1.0,
) -> ReferenceLaw:
    """How `strategy` makes u1; `network_share` is how far `dnn+gp` follows the network (`Tempered`).

    Raises:
        InputError: it needs a network or a lookahead time that was not given.
    """
    match strategy:
        case Strategy.BASELINE:
            return position_velocity
        case Strategy.FEEDFORWARD | Strategy.GP:
            return position_velocity_acceleration
        case Strategy.LOOKAHEAD:
            if lookahead_s is None:
                raise InputError("strategy lookahead needs a time: give --lookahead SECONDS, or a --model")
            return Lookahead(lookahead_s)
        case Strategy.DNN | Strategy.DNN_GP:
            if network is None:
                raise InputError(f"strategy {strategy} needs a network: give --model")
            inverse = InverseDynamics(network)
            tempered = strategy is Strategy.DNN_GP and network_share < 1.0
            return Tempered(inverse, network_share) if tempered else inverse

"""The strategies: how the reference u1 is made from the trajectory, and whether an online model corrects it.

| strategy      | u1                                                    | u2                |
|---------------|-------------------------------------------------------|-------------------|
| `baseline`    | position and velocity                                 | none              |
| `feedforward` | position, velocity and acceleration                   | none              |
| `lookahead`   | position and velocity, a constant time early          | none              |
| `dnn`         | inverse network of a source vehicle                   | none              |
| `gp`          | the same as `feedforward`, its parts somewhat early   | online correction |
| `dnn+gp`      | as `gp`, from which `supervision` goes a part of the  | online correction |
|               | way to a network's; or the paper's: as `dnn`          |                   |
"""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Protocol

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Vec3
from companion.errors import InputError
from companion.flight.preview import desired_ahead, flat_state, state_of
from companion.flight.reference import Reference
from companion.learning.features import inverse_inputs, reference
from companion.learning.inverse_network import InverseNetwork
from companion.learning.library import Library
from companion.learning.online_settings import DEFAULT, OnlineSettings, ReferenceLead
from companion.learning.symmetry import symmetric_answer
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
    """u1 of the paper: what brings the source vehicle, from the state it is in, onto the trajectory."""

    network: InverseNetwork

    def __call__(self, trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        """The reference for the vehicle's estimated state (Eqn. dnnMapping)."""
        x = state_of(state)
        return Reference(*reference(x, self.network(_inputs(self.network, x, trajectory, time_s))))


@dataclass(frozen=True, slots=True)
class Early:
    """Feed-forward whose parts are sent early, each by what the vehicle needs to obey it."""

    lead: ReferenceLead

    def __call__(self, trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        """Position, velocity and acceleration of the trajectory, each its lead from now."""
        at, lead = trajectory.at, self.lead
        return Reference(
            _joined(
                at(time_s + lead.position_s).position,
                at(time_s + lead.vertical_position_s).position,
            ),
            _joined(
                at(time_s + lead.velocity_s).velocity,
                at(time_s + lead.vertical_velocity_s).velocity,
            ),
            _joined(
                at(time_s + lead.acceleration_s).acceleration,
                at(time_s + lead.vertical_acceleration_s).acceleration,
            ),
        )


def _joined(sideways: Vec3, vertical: Vec3) -> Vec3:
    """North and east of the one, down of the other."""
    return np.array([*sideways[:2], vertical[2]])


@dataclass(frozen=True, slots=True)
class InverseFeedforward:
    """u1 that keeps the source vehicle on the trajectory: its inverse network, fed with no estimate.

    What is fed back through another vehicle's inverse may swing, and an estimate that wanders is none that
    the network learned from; an error is left to the autopilot and to the online correction. The acceleration
    stays the trajectory's own, sent early: that much is alike on all multirotors, and known without one.
    Of the network what is alike in every mirror (`learning.symmetry`).
    """

    network: InverseNetwork
    lead: ReferenceLead = DEFAULT.lead

    def __call__(self, trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        """The reference for a vehicle that is where the trajectory is."""
        x = flat_state(trajectory, time_s)
        inputs = _inputs(self.network, x, trajectory, time_s)
        learned = Reference(*reference(x, symmetric_answer(self.network, inputs)))
        if learned.acceleration is None:
            return learned
        return replace(learned, acceleration=Early(self.lead)(trajectory, time_s, state).acceleration)


def _inputs(
    network: InverseNetwork, x: Float[Array, "12"], trajectory: Trajectory, time_s: float
) -> Float[Array, "12"]:
    """I1: what the network sees in the state `x` of what the trajectory needs next."""
    return inverse_inputs(x, *desired_ahead(trajectory, time_s, network.card.preview))


def reference_law(
    strategy: Strategy,
    *,
    network: InverseNetwork | Library | None = None,
    lookahead_s: float | None = None,
    online: OnlineSettings = DEFAULT,
) -> ReferenceLaw:
    """How `strategy` makes u1, with the lead and the network's share of the `online` settings.

    Raises:
        InputError: it needs a network or a lookahead time that was not given.
    """
    match strategy:
        case Strategy.BASELINE:
            return position_velocity
        case Strategy.FEEDFORWARD:
            return position_velocity_acceleration
        case Strategy.GP:
            return Early(online.lead)
        case Strategy.LOOKAHEAD:
            if lookahead_s is None:
                raise InputError("strategy lookahead needs a time: give --lookahead SECONDS, or a --model")
            return Lookahead(lookahead_s)
        case Strategy.DNN | Strategy.DNN_GP:
            if network is None:
                raise InputError(f"strategy {strategy} needs a network: give --model")
            blends = online.judges_networks if isinstance(network, Library) else online.blends_networks
            if strategy is Strategy.DNN_GP and blends:
                return Early(online.lead)
            if isinstance(network, Library):
                raise InputError("a library serves strategy dnn+gp in our settings: name one --model instead")
            return InverseDynamics(network)

"""Faults of the companion itself: a loop that stalls, a network that errs, a process that dies."""

import asyncio
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.clock import VirtualTimeLoop
from companion.learning.inverse_network import InverseNetwork


class Sabotage(StrEnum):
    """What fails, by its name in tables; `Sabotaged.amount` says how much of it."""

    LOOP_STALLED = "loop_stalled"
    """The whole process is held up once, for so many seconds."""
    INFERENCE_SLOW = "inference_slow"
    """Each answer of the network takes so many seconds."""
    MODEL_NAN = "model_nan"
    """The network's answers are no numbers."""
    MODEL_WILD = "model_wild"
    """They are off by so many metres (and m/s, and m/s²)."""
    MODEL_FROZEN = "model_frozen"
    """They stay what they were."""
    MODEL_RAISES = "model_raises"
    """The network raises an error that nobody expects."""
    PROCESS_KILLED = "process_killed"
    """The process ends at once and hands nothing over."""
    SECOND_COMPANION = "second_companion"
    """Another program sends setpoints so many metres beside, for three seconds."""


class ModelBrokenError(Exception):
    """What a network raises that is broken."""


@dataclass(eq=False)
class Saboteur:
    """Does it, from when it is told to.

    Attributes:
        what: which fault; None for none.
        amount: how much of it.
        struck: whether it is there.
    """

    what: Sabotage | None
    amount: float = 0.0
    struck: bool = False
    _last: Float[Array, "..."] | None = None

    def answer(self, outputs: Float[Array, "*n m"]) -> Float[Array, "*n m"]:
        """What the network answers in place of `outputs`."""
        if not self.struck:
            self._last = outputs
            return outputs
        match self.what:
            case Sabotage.INFERENCE_SLOW:
                hold_up(self.amount)
            case Sabotage.MODEL_NAN:
                return np.full_like(outputs, np.nan)
            case Sabotage.MODEL_WILD:
                return outputs + self.amount
            case Sabotage.MODEL_FROZEN:
                return outputs if self._last is None else self._last
            case Sabotage.MODEL_RAISES:
                raise ModelBrokenError("the network is broken")
        return outputs


@dataclass(frozen=True, eq=False)
class SabotagedNetwork(InverseNetwork):
    """An inverse network whose answers somebody tampers with."""

    saboteur: Saboteur

    def __call__(self, inputs: Float[Array, "*n 12"]) -> Float[Array, "*n m"]:
        """The outputs, as the saboteur has them."""
        return self.saboteur.answer(super().__call__(inputs))


def sabotaged(network: InverseNetwork, saboteur: Saboteur) -> SabotagedNetwork:
    """The same network, in the hands of a saboteur."""
    return SabotagedNetwork(
        network.card, network.layers, network.input_scaling, network.output_scaling, saboteur
    )


def hold_up(seconds: float) -> None:
    """Let virtual time pass while nothing else can run."""
    loop = asyncio.get_running_loop()
    assert isinstance(loop, VirtualTimeLoop)
    loop.jump(seconds)

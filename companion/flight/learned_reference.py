"""What networks add to the reference without them: as much as helps, of the one that helps most."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Vec3
from companion.autopilot.position_loop import PositionLoop
from companion.flight.reference import Reference
from companion.flight.strategies import ReferenceLaw
from companion.learning.negative_transfer import Displacement, NetworkJudge, bounded
from companion.learning.online_settings import OnlineSettings
from companion.learning.selection import Selection
from companion.state import VehicleState
from companion.trajectory.trajectory import Trajectory

_FARTHEST_M = 0.1
"""So far a network may pull the vehicle off the unlearned reference, held by autopilot and correction."""
_HEARD_M = 2e-3
"""A network that would move the vehicle by less says the same as the unlearned reference."""
_AGAIN = 50
"""So many finite answers in a row make up for one that was not."""


class LearnedReference:
    """Blends the references of networks into the unlearned one, step by step: `judge`, then `blend`.

    Those that are followed are asked at each step, of the others one a step in turn, for the sake of time.

    Args:
        laws: how each network makes a reference; there may be none.
        settings: of the online correction.
    """

    def __init__(self, laws: Sequence[ReferenceLaw], settings: OnlineSettings) -> None:
        self._laws = laws
        self._judge = NetworkJudge(len(laws), settings.network_share, settings.harm_memory_s)
        self._selection = Selection(len(laws))
        self._finite_in_a_row = [_AGAIN] * len(laws)
        self._turn = 0
        self._pulls: Float[Array, "n 3"] = np.zeros((len(laws), 3))
        self._flown_pull: Vec3 = np.zeros(3)
        self._would_move, self._moved = Displacement(), Displacement()

    @property
    def chosen(self) -> int | None:
        """The place of the network that is followed, as far as it helps."""
        return self._selection.chosen

    @property
    def share(self) -> float:
        """How far the networks are followed, 0 to 1."""
        return float(self._shares.sum())

    @property
    def left_out(self) -> frozenset[int]:
        """The places of the networks that have not answered finite numbers of late."""
        return frozenset(place for place, count in enumerate(self._finite_in_a_row) if count < _AGAIN)

    @property
    def _shares(self) -> Float[Array, " n"]:
        return np.multiply(self._selection.weights, self._judge.shares)

    def judge(self, error: Vec3, held: PositionLoop, duration_s: float) -> None:
        """A step passed, with this tracking error (m), autopilot and correction together being `held`."""
        would_move = self._would_move.pull(self._pulls, *held, duration_s)
        moved = self._moved.pull(self._flown_pull, *held, duration_s)
        self._judge.judge(error, moved, would_move, duration_s)
        tells = bool((np.abs(would_move) > _HEARD_M).any())
        self._selection.choose(self._judge.gains, tells=tells, duration_s=duration_s)

    def blend(
        self,
        unlearned: Reference,
        trajectory: Trajectory,
        time_s: float,
        state: VehicleState,
        *,
        loop: PositionLoop,
        held: PositionLoop,
        most: float,
    ) -> Reference:
        """`unlearned`, and of the networks what is left of them, at most the share `most`.

        `loop` is the autopilot's own, `held` together with the correction.
        """
        learned, followed = unlearned, 0.0
        shares = self._shares
        for place in self._due(shares):
            reference = self._laws[place](trajectory, time_s, state)
            pull = unlearned.pull_towards(reference, *loop)
            part = bounded(pull, held.stiffness_1_s2, _FARTHEST_M)
            is_finite = part > 0.0
            self._finite_in_a_row[place] = self._finite_in_a_row[place] + 1 if is_finite else 0
            self._pulls[place] = part * pull if is_finite else 0.0
            share = part * min(float(shares[place]), most)
            if share > 0.0:
                followed += share
                learned = learned.towards(reference, share / followed)
        blended = unlearned.towards(learned, min(followed, 1.0)) if followed > 0.0 else unlearned
        self._flown_pull = unlearned.pull_towards(blended, *loop)
        return blended

    def _due(self, shares: Float[Array, " n"]) -> list[int]:
        """The places of those that are to be asked now."""
        if not self._laws:
            return []
        self._turn = (self._turn + 1) % len(self._laws)
        return [place for place, share in enumerate(shares) if share > 0.0 or place == self._turn]

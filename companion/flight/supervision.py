"""The guard against negative transfer in flight: how much of network and online correction is flown.

`learning.negative_transfer` says how that is judged; here references become the pulls that are judged.
"""

import math

import numpy as np

from companion.arrays import Vec3
from companion.autopilot.position_loop import PositionLoop
from companion.flight.online_correction import OnlineStep
from companion.flight.reference import Correction, Reference
from companion.flight.strategies import InverseFeedforward, ReferenceLaw, Strategy
from companion.learning.inverse_network import InverseNetwork
from companion.learning.negative_transfer import (
    CorrectionJudge,
    Displacement,
    NetworkJudge,
    Shares,
    bounded,
    loop_gain,
)
from companion.learning.online_settings import OnlineSettings
from companion.state import VehicleState
from companion.trajectory.trajectory import Trajectory

_FARTHEST_M = 0.1
"""So far a network may pull the vehicle off the plain reference, held by autopilot and correction."""
_LONGEST_STEP_S = 0.2
_OUT, _IN = 0.02, 0.1
"""Shares of a network that count as none, and again as some."""


class Supervision:
    """How much of network and correction is flown, over one flight: at each step `u1`, then `u2`.

    Args:
        settings: of the online correction.
        network: how what was learned before the flight makes a reference, if anything was.

    Attributes:
        shares: what is flown.
    """

    def __init__(self, settings: OnlineSettings, network: ReferenceLaw | None = None) -> None:
        usual_share = 0.0 if network is None else settings.network_share
        self.shares = Shares(usual_share, 1.0)
        self._damping_1_s = settings.damping_1_s
        self._law = network
        self._of_network = NetworkJudge(usual_share, settings.harm_memory_s)
        self._of_correction = CorrectionJudge(settings.harm_memory_s)
        self._network, self._correction = _Pull(), _Pull()
        self._loop_gain = 1.0
        self._held: PositionLoop | None = None
        self._time_s = math.inf
        self._said = (network is not None, True)

    def u1(
        self, plain: Reference, trajectory: Trajectory, time_s: float, state: VehicleState, loop: PositionLoop
    ) -> Reference:
        """`plain`, and of the network what is left of it, at `time_s` on the trajectory (s).

        `loop` is the autopilot's own.
        """
        held = loop if self._held is None else self._held
        self._judge(trajectory.at(time_s).position - state.position, state.time_s, loop, held)
        if self._law is None:
            return plain
        learned = self._law(trajectory, time_s, state)
        pull = plain.pull_towards(learned, *loop)
        part = bounded(pull, held.stiffness_1_s2, _FARTHEST_M)
        self._network.acceleration = part * pull if part > 0.0 else np.zeros(3)
        share = part * self.shares.network
        return plain.towards(learned, share) if share > 0.0 else plain

    def u2(self, online: OnlineStep, loop: PositionLoop) -> Correction:
        """What is left of the online correction."""
        share = self.shares.correction
        self._correction.acceleration = online.u2.pull(*loop)
        self._loop_gain = float(loop_gain(online.alpha, online.predicted.gradient).max())
        self._held = PositionLoop(
            loop.stiffness_1_s2 * (1.0 + share * online.alpha), loop.damping_1_s + share * self._damping_1_s
        )
        return online.u2 if share == 1.0 else online.u2.scaled(share)

    def remarks(self) -> list[str]:
        """What has changed since this was asked for last, in words."""
        network_was, correction_was = self._said
        network = self.shares.network > (_OUT if network_was else _IN)
        correction = self._of_correction.believed
        self._said = network, correction
        said = []
        if correction != correction_was:
            said.append(
                "the online correction would help again: faded in"
                if correction
                else "negative transfer: the online correction does harm and is faded out"
            )
        if network != network_was:
            said.append(
                "the network would help again: faded in"
                if network
                else "negative transfer: the network does harm and is faded out"
            )
        return said

    def _judge(self, error: Vec3, time_s: float, loop: PositionLoop, held: PositionLoop) -> None:
        duration_s = min(max(time_s - self._time_s, 0.0), _LONGEST_STEP_S)
        self._time_s = time_s
        moved, would_move = self._network.act(self.shares.network, held, held, duration_s)
        self._of_network.judge(error, moved, would_move, duration_s)
        moved, would_move = self._correction.act(self.shares.correction, loop, held, duration_s)
        self._of_correction.judge(error, moved, would_move, self._loop_gain, duration_s)
        correction = self._of_correction.share
        self.shares = Shares(min(self._of_network.share, correction), correction)


class _Pull:
    """What pulls at the vehicle, and how far that moves it, in part and in full.

    Attributes:
        acceleration: in full (m/s²).
    """

    def __init__(self) -> None:
        self.acceleration: Vec3 = np.zeros(3)
        self._flown, self._full = Displacement(), Displacement()

    def act(
        self, share: float, held_flown: PositionLoop, held_full: PositionLoop, duration_s: float
    ) -> tuple[Vec3, Vec3]:
        """How far the share of it has moved the vehicle, and all of it would have (m)."""
        return (
            self._flown.pull(share * self.acceleration, *held_flown, duration_s),
            self._full.pull(self.acceleration, *held_full, duration_s),
        )


def supervision_of(
    strategy: Strategy, network: InverseNetwork | None, online: OnlineSettings
) -> Supervision | None:
    """Of a flight with this strategy; None where nothing is learned online."""
    if not strategy.learns_online:
        return None
    tempers = strategy is Strategy.DNN_GP and network is not None and online.network_share < 1.0
    return Supervision(online, InverseFeedforward(network) if tempers and network is not None else None)

"""The guard against negative transfer in flight: how much of networks and online correction is flown.

`learning.negative_transfer` says how that is judged; here references become the pulls that are judged.
"""

import math
from collections import deque
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from companion.arrays import Vec3
from companion.autopilot.position_loop import PositionLoop
from companion.flight.learned_reference import LearnedReference
from companion.flight.online_correction import OnlineStep
from companion.flight.reference import Correction, Reference
from companion.flight.strategies import InverseFeedforward, ReferenceLaw, Strategy
from companion.learning.inverse_network import InverseNetwork
from companion.learning.library import Library
from companion.learning.negative_transfer import CorrectionJudge, Displacement, Shares, loop_gain
from companion.learning.online_settings import OnlineSettings
from companion.state import VehicleState
from companion.trajectory.trajectory import Trajectory

_LONGEST_STEP_S = 0.2
_OUT, _IN = 0.02, 0.1
"""Shares of networks that count as none, and again as some."""


class Supervision:
    """How much of networks and correction is flown, over one flight: at each step `u1`, then `u2`.

    Args:
        settings: of the online correction.
        laws: how the networks make references, by the networks' names.

    Attributes:
        shares: what is flown.
    """

    def __init__(
        self, settings: OnlineSettings, laws: Mapping[str, ReferenceLaw] = MappingProxyType({})
    ) -> None:
        self._names = list(laws)
        self._learned = LearnedReference(list(laws.values()), settings)
        self._of_correction = CorrectionJudge(settings.harm_memory_s)
        self._correction_pull: Vec3 = np.zeros(3)
        self._moved, self._would_move = Displacement(), Displacement()
        self._damping_1_s = settings.damping_1_s if settings.velocity == "predicted" else 0.0
        self._loop_gain = 1.0
        self._held: PositionLoop | None = None
        self._time_s = math.inf
        self._preview_s = settings.preview.longest_s
        self._predicted: deque[tuple[float, Vec3]] = deque()
        self.shares = Shares(self._learned.share, 1.0)
        self._network_was_harmful = False
        self._said = (self.followed, self._learned.left_out, self.shares.network > 0.0, True)

    @property
    def followed(self) -> str | None:
        """The name of the network that is followed, as far as it helps."""
        chosen = self._learned.chosen
        return None if chosen is None else self._names[chosen]

    def u1(
        self,
        unlearned: Reference,
        trajectory: Trajectory,
        time_s: float,
        state: VehicleState,
        loop: PositionLoop,
    ) -> Reference:
        """`unlearned`, and of the networks what is left of them, at `time_s` on the trajectory (s).

        `loop` is the autopilot's own.
        """
        held = loop if self._held is None else self._held
        self._judge(trajectory.at(time_s).position - state.position, state.time_s, loop, held)
        return self._learned.blend(
            unlearned, trajectory, time_s, state, loop=loop, held=held, most=self.shares.correction
        )

    def u2(self, online: OnlineStep, loop: PositionLoop) -> Correction:
        """What is left of the online correction."""
        share = self.shares.correction
        self._correction_pull = online.u2.pull(*loop)
        self._predicted.append((self._time_s + self._preview_s, online.predicted.error))
        self._loop_gain = float(loop_gain(online.alpha, online.predicted.gradient).max())
        self._held = PositionLoop(
            loop.stiffness_1_s2 * (1.0 + share * online.alpha), loop.damping_1_s + share * self._damping_1_s
        )
        return online.u2 if share == 1.0 else online.u2.scaled(share)

    def remarks(self) -> list[str]:
        """What has changed since this was asked for last, in words."""
        followed_was, left_out_was, active_was, believed_was = self._said
        followed, left_out = self.followed, self._learned.left_out
        believed = self._of_correction.believed
        active = self.shares.network > (_OUT if active_was else _IN)
        self._said = followed, left_out, active, believed
        said = []
        if followed is not None and followed != followed_was:
            said.append(f"following the network of {followed}")
        for place in sorted(left_out ^ left_out_was):
            fault = "not finite and is left out" if place in left_out else "finite again"
            said.append(f"the answer of the network of {self._names[place]} is {fault}")
        if active_was and not active:
            said.append("negative transfer: the network did harm and is faded out")
            self._network_was_harmful = True
        if active and not active_was and self._network_was_harmful:
            said.append("the network helps again and is faded in")
        if believed_was and not believed:
            said.append("negative transfer: the online correction does harm and is faded out")
        if believed and not believed_was:
            said.append("the online correction would help again and is faded in")
        return said

    def _judge(self, error: Vec3, time_s: float, loop: PositionLoop, held: PositionLoop) -> None:
        duration_s = min(max(time_s - self._time_s, 0.0), _LONGEST_STEP_S)
        self._time_s = time_s
        self._learned.judge(error, held, duration_s)
        self._of_correction.judge(
            error,
            self._predicted_for(time_s),
            self._moved.pull(self.shares.correction * self._correction_pull, *loop, duration_s),
            self._would_move.pull(self._correction_pull, *held, duration_s),
            self._loop_gain,
            duration_s,
        )
        correction = self._of_correction.share
        self.shares = Shares(min(self._learned.share, correction), correction)

    def _predicted_for(self, time_s: float) -> Vec3:
        """The error that was predicted for `time_s`; zero where none was, or none that is finite."""
        predicted: Vec3 = np.zeros(3)
        while self._predicted and self._predicted[0][0] <= time_s:
            _, predicted = self._predicted.popleft()
        return predicted if np.isfinite(predicted).all() else np.zeros(3)


def supervision_of(
    strategy: Strategy, network: InverseNetwork | Library | None, online: OnlineSettings
) -> Supervision | None:
    """Of a flight with this strategy; None where nothing is learned online."""
    if not strategy.learns_online:
        return None
    if strategy is not Strategy.DNN_GP or network is None or not online.blends_networks:
        return Supervision(online)
    networks = network.networks if isinstance(network, Library) else {network.card.vehicle: network}
    laws = {name: InverseFeedforward(each, online.lead) for name, each in networks.items()}
    return Supervision(online, laws)

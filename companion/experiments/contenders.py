"""Who flies in a comparison: a vehicle, a strategy, and where that needs one a network.

| contender        | vehicle | network      | compared with         |
|------------------|---------|--------------|-----------------------|
| the strategies   | target  | the source's | the target's baseline |
| `target_own_dnn` | target  | its own      | the target's baseline |
| `source_own_dnn` | source  | its own      | the source's baseline |
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from companion import bundled
from companion.errors import InputError
from companion.experiments.results import BASELINE
from companion.experiments.simulated_flights import Scenario
from companion.flight.strategies import Strategy
from companion.learning.inverse_network import InverseNetwork
from companion.learning.library import AUTO, Library, load_library
from companion.learning.model_file import load_model
from companion.learning.online_settings import PAPER, OnlineSettings
from companion.trajectory.trajectory import Trajectory

TARGET_OWN, SOURCE_OWN, SOURCE_BASELINE = "target_own_dnn", "source_own_dnn", "source_baseline"


@dataclass(frozen=True, eq=False)
class Model:
    """A network, and the name of its file."""

    name: str
    network: InverseNetwork


@dataclass(frozen=True, eq=False)
class Several:
    """Networks of which a flight takes whichever helps, and what they are called together."""

    name: str
    network: Library


@dataclass(frozen=True, eq=False)
class Contender:
    """A vehicle with a strategy.

    Attributes:
        vehicle: name in `config/vehicles`, or a YAML file.
        strategy: how it flies.
        model: for the strategies that need a network.
        lookahead_s: for the strategy that needs it (s).
        compared_with: which contender its reduction is against.
    """

    vehicle: str
    strategy: Strategy
    model: Model | Several | None = None
    lookahead_s: float | None = None
    compared_with: str = BASELINE

    def scenario(
        self, trajectory: Trajectory, conditions: str, seed: int, online: OnlineSettings
    ) -> Scenario:
        """Its flight along `trajectory` (NED relative to the takeoff point, m)."""
        return Scenario(
            trajectory,
            self.strategy,
            vehicle=self.vehicle,
            conditions=conditions,
            seed=seed,
            network=None if self.model is None else self.model.network,
            lookahead_s=self.lookahead_s,
            online=online,
        )


Contenders: TypeAlias = dict[str, Contender]
"""By their names in tables and summaries."""


def lookahead_of(contenders: Contenders) -> float | None:
    """The constant lookahead that is flown (s), None if none is."""
    return next((each.lookahead_s for each in contenders.values() if each.lookahead_s is not None), None)


def needs_network(strategy: Strategy) -> bool:
    """Whether the strategy asks an inverse network."""
    return strategy in (Strategy.DNN, Strategy.DNN_GP)


def transferred(
    target: str, strategies: Sequence[Strategy], model: Model | Several | None, lookahead_s: float | None
) -> Contenders:
    """The target with each strategy, with `baseline` in any case, and with `gp` beside `dnn+gp`.

    The network is another vehicle's.
    """
    beside = [Strategy.GP] if Strategy.DNN_GP in strategies else []
    return {
        str(strategy): Contender(
            target,
            strategy,
            model if needs_network(strategy) else None,
            lookahead_s if strategy is Strategy.LOOKAHEAD else None,
        )
        for strategy in dict.fromkeys([Strategy.BASELINE, *strategies, *beside])
    }


def with_own_networks(source: str, of_source: Model, target: str, of_target: Model | None) -> Contenders:
    """Each vehicle with its own network, the target only if it has one."""
    contenders = {
        SOURCE_BASELINE: Contender(source, Strategy.BASELINE),
        SOURCE_OWN: Contender(source, Strategy.DNN, of_source, compared_with=SOURCE_BASELINE),
    }
    if of_target is not None:
        contenders[TARGET_OWN] = Contender(target, Strategy.DNN, of_target)
    return contenders


def own_model_name(vehicle: str, online: OnlineSettings) -> str:
    """What the network of a vehicle (a name, or a YAML file) is called in `config/models`."""
    return f"{Path(vehicle).stem}_paper" if _is_of_the_paper(online) else Path(vehicle).stem


def _is_of_the_paper(online: OnlineSettings) -> bool:
    """Whether its control steps, and so its networks, are those of the paper."""
    return online.sample_time_s == PAPER.sample_time_s


def library_for(target: str, online: OnlineSettings) -> Several:
    """All networks of `config/models` but the target's own.

    Raises:
        InputError: there is none for these settings, or they do not judge what networks do.
    """
    if not online.judges_networks:
        raise InputError(
            "--model auto chooses among networks by what they do, which these settings do not judge: name one"
        )
    library = load_library(bundled.config_directory() / "models", online.sample_time_s)
    return Several(AUTO, library.without(own_model_name(target, online)))


def find_model(name_or_path: str, online: OnlineSettings) -> Model:
    """A network, by the name of a file in `config/models` or by its path.

    Raises:
        InputError: there is none, or it does not fit the paper's settings where those are asked for.
    """
    path = bundled.find("models", name_or_path, ".safetensors")
    network = load_model(path)
    if _is_of_the_paper(online) and network.card.preview != PAPER.preview:
        raise InputError(
            f"{path}: the model was trained for another preview than the paper's, (4, 4, 3) steps at 7 Hz; "
            "train one with the paper's preset"
        )
    return Model(path.stem, network)

"""Several contenders on the same trajectories: flights, their errors, and the means of these."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from companion.experiments.contenders import Contenders
from companion.experiments.flights import Flight
from companion.experiments.results import BASELINE, Cell, RmsErrors, mean_cell
from companion.experiments.simulated_flights import Failed, Flown, Result, evaluate_all
from companion.learning.online_settings import DEFAULT, OnlineSettings
from companion.trajectory.trajectory import Trajectory

Results: TypeAlias = Mapping[tuple[str, str], Result]
"""By the names of trajectory and contender."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Which flights to fly.

    Attributes:
        trajectories: NED relative to the takeoff point (m); their names differ.
        contenders: each flies each trajectory.
        conditions: name in `config/conditions`, or a YAML file.
        seed: of every flight, so that all contenders meet the same wind.
        online: settings of the online correction.
    """

    trajectories: Sequence[Trajectory]
    contenders: Contenders
    conditions: str
    seed: int
    online: OnlineSettings = DEFAULT

    def __len__(self) -> int:
        return len(self.trajectories) * len(self.contenders)

    def fly(self) -> Iterator[tuple[tuple[str, str], Result]]:
        """Names of trajectory and contender with what came of their flight, in order, as flights end."""
        scenarios = {
            (trajectory.name, name): contender.scenario(trajectory, self.conditions, self.seed, self.online)
            for trajectory in self.trajectories
            for name, contender in self.contenders.items()
        }
        return zip(scenarios, evaluate_all(list(scenarios.values())), strict=True)


def rms_errors(results: Results) -> RmsErrors:
    """RMS error against the truth (m) of each flight that came to its end."""
    return {names: flown.accuracy.rms_m for names, flown in _flown(results)}


def flights(results: Results) -> list[Flight]:
    """Each flight that came to its end, under its contender's name."""
    return [replace(flown.flight, strategy=contender) for (_, contender), flown in _flown(results)]


def _flown(results: Results) -> list[tuple[tuple[str, str], Flown]]:
    """What came to its end; by contender, so that a failed first flight moves no column of a table."""
    contenders = list(dict.fromkeys(contender for _, contender in results))
    flown = [(names, result) for names, result in results.items() if isinstance(result, Flown)]
    return sorted(flown, key=lambda each: contenders.index(each[0][1]))


def failures(results: Results) -> list[str]:
    """A line for each flight that failed."""
    return [
        f"{trajectory}, {contender}: {result.reason}"
        for (trajectory, contender), result in results.items()
        if isinstance(result, Failed)
    ]


def means(contenders: Contenders, results: Results) -> dict[str, Cell]:
    """Means over trajectories for each contender that came through at least one."""
    rms_m = rms_errors(results)
    through = {contender for _, contender in rms_m}
    return {
        name: _mean(rms_m, name, contender.compared_with)
        for name, contender in contenders.items()
        if name in through
    }


def _mean(rms_m: RmsErrors, name: str, compared_with: str) -> Cell:
    two = {
        (trajectory, BASELINE if contender == compared_with else contender): rms
        for (trajectory, contender), rms in rms_m.items()
        if contender in (name, compared_with)
    }
    return mean_cell(two, BASELINE if name == compared_with else name)

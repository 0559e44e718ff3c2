"""A simulated flight has the state that its trajectory predicts."""

import numpy as np

from companion.experiments.simulated_flights import Scenario, simulate
from companion.flight.approach import rest_to_rest
from companion.flight.preview import flat_state
from companion.flight.strategies import Strategy
from companion.learning.features import state_vector

DIAGONAL = rest_to_rest(np.array([0.0, 0.0, -2.5]), np.array([2.0, -3.0, -3.0]), "diagonal")
LONGEST_LAG_S = 0.4


def test_a_vehicle_tilts_as_its_trajectory_says_and_somewhat_later() -> None:
    outcome, _, _ = simulate(Scenario(DIAGONAL, Strategy.FEEDFORWARD))
    states = outcome.recording.states
    flown = state_vector(states.position, states.velocity, states.attitude, states.rates)
    time_s = states.time_s - outcome.start_s
    along = (time_s > 0.0) & (time_s < DIAGONAL.duration_s + LONGEST_LAG_S)

    def misfit(lag_s: float) -> float:
        """Share of the tilt's variation that the trajectory, `lag_s` ago, does not explain."""
        predicted = np.array([flat_state(outcome.trajectory, time - lag_s)[6:8] for time in time_s[along]])
        return float(np.mean((flown[along, 6:8] - predicted) ** 2) / np.mean(predicted**2))

    assert min(misfit(lag_s) for lag_s in np.arange(0.0, LONGEST_LAG_S, 0.05)) < 0.05

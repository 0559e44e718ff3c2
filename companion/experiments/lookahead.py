"""The best constant lookahead of a vehicle: what people use who have no model, measured by flying."""

from companion.experiments.simulated_flights import Scenario, simulate
from companion.flight.strategies import Strategy
from companion.learning.training_data import constant_lag
from companion.trajectory.training import training_sinusoids

FLIGHT_S = 80.0


def measured_lookahead_s(vehicle: str, conditions: str, seed: int) -> float:
    """The constant time (s) by which the vehicle, flown by `baseline`, lags on the training sinusoids.

    It is the T for which the flown position p_a(t) is nearest to the reference p_r(t − T), with the velocity
    as feed-forward; sending position and velocity T early therefore tracks those sinusoids best, as far as
    the vehicle is linear. Flown for `FLIGHT_S` in the conditions of the flights that it is for.

    Raises:
        InputError: vehicle or conditions cannot be used.
        FlightError: the flight failed.
    """
    trajectory = training_sinusoids(FLIGHT_S)
    outcome, _, _ = simulate(
        Scenario(trajectory, Strategy.BASELINE, vehicle=vehicle, conditions=conditions, seed=seed)
    )
    return constant_lag(outcome.recording)

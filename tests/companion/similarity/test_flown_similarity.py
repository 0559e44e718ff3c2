"""The line on source and target at the end of a flight, and whose network it is about."""

import numpy as np
import pytest
from spring_flight import spring_flight

from companion import bundled, clock
from companion.cli.flown_similarity import source_of, tell_similarity
from companion.flight.recorder import FlightRecorder
from companion.flight.reference import Reference
from companion.flight.strategies import position_velocity
from companion.flight.supervision import Supervision
from companion.learning.inverse_network import ModelCard
from companion.learning.library import Library
from companion.learning.model_file import load_model
from companion.learning.online_settings import DEFAULT
from companion.recording import Provenance
from companion.state import VehicleState

NETWORK = load_model(bundled.find("models", "ardrone2", ".safetensors"))


def told_of(source: ModelCard, recorder: FlightRecorder) -> str:
    """The one line that is told, and recorded."""
    lines: list[str] = []
    clock.run(tell_similarity(source, recorder, lines.append), virtual=True)
    (line,) = lines
    assert [text for _, text in recorder.recording(Provenance(vehicle="any")).events] == [line]
    return line


def flown() -> FlightRecorder:
    """Forty seconds of a spring's flight."""
    recorder = FlightRecorder()
    flight = spring_flight()
    states, sent = flight.states, flight.references
    parts = (states.position, states.velocity, states.attitude, states.rates)
    for k, time_s in enumerate(states.time_s):
        reference = Reference(sent.position[k], sent.velocity[k], sent.acceleration[k])
        recorder.recent.sent(time_s, reference, 0.0)
        recorder.recent.state(VehicleState(time_s, time_s, *(part[k] for part in parts)))
    return recorder


def test_a_flight_is_told_in_a_line() -> None:
    line = told_of(NETWORK.card, flown())
    assert line.startswith("similarity to ardrone2: north S1 ")
    assert "; east S1 " in line
    assert "; Lemma 1 vacuous (L1 ‖𝒜s/ℬs‖ = " in line


def test_a_flight_that_does_not_tell_is_no_error() -> None:
    line = told_of(NETWORK.card, FlightRecorder())
    assert line == "similarity to ardrone2 not known: no states or no references in this flight: record both"


@pytest.mark.parametrize("count", [2, 10, 50, 120])
def test_a_flight_that_was_too_short_is_no_error(count: int) -> None:
    recorder = FlightRecorder()
    for k in range(count):
        recorder.recent.sent(0.02 * k, Reference(np.zeros(3), np.zeros(3)), 0.0)
        recorder.recent.state(VehicleState(0.02 * k, 0.02 * k, *np.zeros((4, 3))))
    assert "at least 3 s are needed" in told_of(NETWORK.card, recorder)


def test_a_flight_at_rest_is_no_error() -> None:
    recorder = FlightRecorder()
    for k in range(500):
        recorder.recent.sent(0.02 * k, Reference(np.zeros(3), np.zeros(3)), 0.0)
        recorder.recent.state(VehicleState(0.02 * k, 0.02 * k, *np.zeros((4, 3))))
    assert "similarity to ardrone2 not known: " in told_of(NETWORK.card, recorder)


def test_a_card_without_a_model_of_its_vehicle_says_so() -> None:
    card = NETWORK.card.model_copy(update={"loops": None})
    assert "the model's card says nothing" in told_of(card, flown())


def test_the_source_is_what_was_followed() -> None:
    other = load_model(bundled.find("models", "x500", ".safetensors"))
    library = Library({"one": NETWORK, "two": other})
    undecided = Supervision(DEFAULT, dict.fromkeys(library.networks, position_velocity))
    decided = Supervision(DEFAULT, {"two": position_velocity})
    assert source_of(None, undecided) is None
    assert source_of(NETWORK, None) is NETWORK.card
    assert source_of(library, None) is None
    assert source_of(library, undecided) is None
    assert source_of(library, decided) is other.card

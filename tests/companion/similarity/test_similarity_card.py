"""S against a model's card."""

from spring_flight import spring_flight

from companion.similarity.axis_loops import axis_loops
from companion.similarity.card_similarity import card_similarity
from companion.similarity.identification import identify_recording


def test_a_vehicle_is_like_its_own_card_and_unlike_a_stiffer_ones() -> None:
    flight = spring_flight()
    card = axis_loops(flight)
    assert card is not None
    itself = card_similarity(card, identify_recording(flight, resamples=0))
    stiffer = card_similarity(card, identify_recording(spring_flight(stiffness=9.0), resamples=0))
    for axis in range(2):
        assert abs(itself[axis].S1) < 1e-9
        assert itself[axis].S2_norm < 1e-9
        assert stiffer[axis].S1 < -0.3

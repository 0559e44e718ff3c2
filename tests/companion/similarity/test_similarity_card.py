"""S and Lemma 1 against a model's card."""

import json
from dataclasses import replace

import numpy as np
import pytest
from spring_flight import spring_flight

from companion.errors import InputError
from companion.similarity.axis_loops import axis_loops
from companion.similarity.card_similarity import as_json, card_similarity, in_words
from companion.similarity.comparison import compare
from companion.similarity.identification import VehicleModel, identify_recording
from companion.similarity.lemma import StateResponse
from companion.similarity.report import as_json as report_json
from companion.similarity.track_record import MEASURED
from companion.similarity.verdict import verdict


def test_a_vehicle_is_like_its_own_card_and_unlike_a_stiffer_ones() -> None:
    flight = spring_flight()
    card = axis_loops(flight)
    assert card is not None
    itself = card_similarity(card, identify_recording(flight, resamples=0))
    stiffer = card_similarity(card, identify_recording(spring_flight(stiffness=9.0), resamples=0))
    for axis in ("north", "east"):
        assert abs(itself[axis].s.S1) < 1e-9
        assert itself[axis].s.S2_norm < 1e-9
        assert stiffer[axis].s.S1 < -0.3


def test_a_card_says_the_same_as_the_flight_that_it_is_of() -> None:
    """Scaled by the target's motion alone where both are the same flight, so that the scales are equal."""
    flight = spring_flight(noise=1e-3)
    card = axis_loops(flight)
    assert card is not None
    model = identify_recording(flight, resamples=20)
    terms = card_similarity(card, model)
    for axis in compare(model, model):
        ours, theirs = terms[axis.axis].lemma, axis.figures.lemma
        assert ours.response == theirs.response
        assert ours.beta_4 == pytest.approx(theirs.beta_4)
        assert ours.prediction.beta_1 == pytest.approx(theirs.prediction.beta_1)
        assert ours.prediction.beta_2 == pytest.approx(theirs.prediction.beta_2)
        assert ours.prediction.beta_3 == pytest.approx(theirs.prediction.beta_3)


def still_along_north(model: VehicleModel) -> VehicleModel:
    north, east, down = model.axes
    return replace(model, axes=(replace(north, spread=0.01 * north.spread), east, down))


def test_an_axis_along_which_the_vehicle_hardly_moved_is_left_out() -> None:
    flight = spring_flight()
    card, model = axis_loops(flight), identify_recording(flight, resamples=0)
    assert card is not None
    assert set(card_similarity(card, still_along_north(model))) == {"east", "down"}
    north, _, _ = still_along_north(model).axes
    with pytest.raises(InputError, match="fly farther"):
        card_similarity(card, replace(model, axes=(north, north, north)))


def test_the_terms_in_words_and_for_programs() -> None:
    flight = spring_flight()
    card = axis_loops(flight)
    assert card is not None
    bare = card_similarity(card, identify_recording(flight, resamples=0))
    assert "north S1 0.00, ‖S2‖ 0.00; " in in_words(bare)
    terms = card_similarity(card, identify_recording(flight, resamples=5))
    drawn = [s.S1 for s in terms["north"].resampled]
    assert f"({min(drawn):.2f} to {max(drawn):.2f}), ‖S2‖ 0.00 (0.0" in in_words(terms)
    assert "Lemma 1 vacuous (L1 ‖𝒜s/ℬs‖ = " in in_words(terms)
    told = as_json(terms["north"])
    assert told["lemma_1_vacuous"] is True
    assert told["s1_resampled"] == drawn
    assert len(drawn) == len(told["s2_norm_resampled"]) == 5
    assert told["lemma_1_alpha"] == 0.0
    axis = compare(identify_recording(flight, resamples=0), identify_recording(flight, resamples=0))
    named = report_json(axis, verdict(axis), MEASURED)["axes"]["north"]
    assert set(told) - set(named) - set(named["figures"]) == {"s1_resampled", "s2_norm_resampled"}
    assert told["scenario_i_holds"] is False
    assert told["lemma_1_state"] is None
    assert told["l1_limit"] == pytest.approx(1.0 / told["inverse_state_gain"])
    assert told["l1"] * told["inverse_state_gain"] == pytest.approx(1.0 - told["beta_4"])
    unstable = terms["north"].lemma
    unstable = replace(unstable, response=StateResponse(np.inf, np.inf))
    told = as_json(terms["north"]._replace(lemma=unstable))
    assert told["l1"] is told["beta_4"] is None
    json.dumps(told, allow_nan=False)


def test_where_lemma_1_holds_its_bound_is_told() -> None:
    flight = spring_flight()
    card = axis_loops(flight)
    assert card is not None
    terms = card_similarity(card, identify_recording(flight, resamples=0))
    mild = {
        axis: each._replace(lemma=replace(each.lemma, inverse_state_gain=0.1, S2_norm=0.2))
        for axis, each in terms.items()
    }
    least = min(each.lemma.largest_gain for each in mild.values())
    assert 0.0 < least < np.inf
    assert in_words(mild).endswith(f"Lemma 1 allows α under {least:.2g}")

"""At the end of a flight with a network: how alike its source and the vehicle that flew are."""

import asyncio

import numpy as np

from companion import clock
from companion.errors import InputError
from companion.flight.recorder import Recorder
from companion.flight.supervision import Supervision
from companion.flight.takeoff import Announce
from companion.learning.inverse_network import AxisLoops, InverseNetwork, ModelCard
from companion.learning.library import Library
from companion.recording.series import ReferenceSeries, StateSeries
from companion.similarity.card_similarity import CardTerms, as_json, card_similarity, in_words
from companion.similarity.identification import identify

KIND = "similarity"
_RESAMPLES = 20
"""For bounds on what an online module can know of the vehicle; they take 60 ms."""


def source_of(network: InverseNetwork | Library | None, supervision: Supervision | None) -> ModelCard | None:
    """The card of the network that was followed, of a library's the last; None where none was."""
    if isinstance(network, Library):
        followed = None if supervision is None else supervision.followed
        return None if followed is None else network.networks[followed].card
    return None if network is None else network.card


async def tell_similarity(source: ModelCard, recorder: Recorder, announce: Announce) -> None:
    """Record S1, S2 and the terms of Lemma 1 as an event, and tell them in a line.

    Where the flight does not tell, the line says why.

    Args:
        source: the card of the network that was flown.
        recorder: of the flight.
        announce: told the line.
    """
    about, data = f"similarity to {source.vehicle}", None
    try:
        axes = await asyncio.to_thread(_terms, source.loops, *recorder.recent.series())
    except (InputError, np.linalg.LinAlgError) as error:
        text = f"{about} not known: {error}"
    else:
        text = f"{about}: {in_words(axes)}"
        data = {"source": source.vehicle} | {axis: as_json(each) for axis, each in axes.items()}
    announce(text)
    recorder.event(clock.now(), text, KIND, data)


def _terms(
    source: AxisLoops | None, states: StateSeries, references: ReferenceSeries
) -> dict[str, CardTerms]:
    if source is None:
        raise InputError("the model's card says nothing of how its vehicle answers")
    return card_similarity(source, identify(states, references, resamples=_RESAMPLES))

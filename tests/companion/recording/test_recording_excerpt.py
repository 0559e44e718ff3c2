"""Cutting a part out of a recording."""

from dataclasses import replace

import numpy as np

from companion.recording import Provenance, Recording, ReferenceSeries, Segment, StateSeries, Window, cut


def recording() -> Recording:
    time_s = np.arange(0.0, 10.0)
    rows = np.outer(time_s, np.ones(3))
    return Recording(
        Provenance(vehicle="bebop2"),
        StateSeries(time_s, rows, rows, rows, rows),
        ReferenceSeries(time_s + 0.5, rows, rows, rows, time_s),
        events=((1.0, "armed"), (4.0, "landed")),
        segments=(Segment("first", Window(0.0, 2.0)), Segment("second", Window(2.0, 4.0))),
        hover=Window(3.0, 4.0),
    )


def test_a_cut_holds_what_lies_within_it_both_ends_included() -> None:
    part = cut(recording(), 2.0, 4.0)
    assert part.states.time_s.tolist() == [2.0, 3.0, 4.0]
    assert part.states.position[:, 0].tolist() == [2.0, 3.0, 4.0]
    assert part.references.time_s.tolist() == [2.5, 3.5]
    assert part.references.yaw.tolist() == [2.0, 3.0]
    assert part.events == ((4.0, "landed"),)
    assert part.provenance.vehicle == "bebop2"
    assert part.tracking is None


def test_a_cut_keeps_only_whole_segments_and_a_whole_hover() -> None:
    assert [segment.id for segment in cut(recording(), 2.0, 4.0).segments] == ["second"]
    assert cut(recording(), 2.0, 4.0).hover == Window(3.0, 4.0)
    assert cut(recording(), 0.0, 3.5).hover is None
    assert cut(replace(recording(), hover=None), 0.0, 9.0).hover is None

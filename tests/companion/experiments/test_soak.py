"""A fixed slice of `companion bench soak`: minutes instead of hours."""

import pytest

from companion.experiments.contenders import find_model
from companion.experiments.soak import Piece, pieces, soak
from companion.learning.online_settings import DEFAULT

NETWORK = find_model("ardrone2", DEFAULT).network


def test_two_flights_of_one_process_leave_nothing_behind() -> None:
    row = soak(Piece("bebop2", "realistic", NETWORK, 0, duration_s=60.0, flight_s=20.0))
    assert row.flights == 2
    assert row.lost == 0
    assert row.setpoints > 2 * 20 * 40
    assert max(row.late_s) < 1e-6
    assert row.drift_s < 1e-6
    assert row.grown < 0.05
    assert row.worst_rms_m < 0.1


def test_pieces_share_the_time_and_differ_in_their_seeds() -> None:
    shared = pieces(Piece("bebop2", "ideal", NETWORK, 3, duration_s=100.0), 4)
    assert [piece.seed for piece in shared] == [3, 4, 5, 6]
    assert sum(piece.duration_s for piece in shared) == pytest.approx(100.0)

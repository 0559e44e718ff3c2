import pytest

from companion.cli import options
from companion.errors import InputError
from companion.flight.flight import After


@pytest.mark.parametrize(
    ("asked", "land", "means"),
    [
        (None, False, After.HOLD),
        (None, True, After.LAND),
        (After.LAND, True, After.LAND),
        (After.RETURN, False, After.RETURN),
    ],
)
def test_the_vehicle_is_handed_back_by_either_option(
    asked: After | None, *, land: bool, means: After
) -> None:
    assert options.after(asked, land=land) is means


@pytest.mark.parametrize("asked", [After.HOLD, After.RETURN])
def test_land_and_another_end_contradict(asked: After) -> None:
    with pytest.raises(InputError, match="contradict"):
        options.after(asked, land=True)

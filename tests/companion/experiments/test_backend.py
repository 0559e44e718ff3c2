"""Many calls on a backend of joblib."""

import operator
from importlib.util import find_spec

import joblib
import pytest

from companion.errors import InputError
from companion.experiments.backend import Backend, _in_rounds

ITEMS = list(range(20))


@pytest.mark.parametrize("name", ["loky", "threading", "sequential"])
def test_results_come_in_order(name: str) -> None:
    assert list(Backend(name).each(operator.neg, ITEMS)) == [-item for item in ITEMS]


def test_who_stops_early_hears_nothing_of_the_rest() -> None:
    results = Backend("threading").each(operator.neg, ITEMS)
    assert next(results) == 0
    del results


def test_rounds_hold_all_items_in_order() -> None:
    tasks = (joblib.delayed(operator.neg)(item) for item in ITEMS)
    assert list(_in_rounds(joblib.Parallel(n_jobs=1), tasks)) == [-item for item in ITEMS]


@pytest.mark.parametrize("name", ["nonsense", "ray", "dask"])
def test_a_backend_that_is_not_there_is_named(name: str) -> None:
    if find_spec(name) is not None:
        pytest.skip(f"{name} is installed")
    with pytest.raises(InputError, match=f"--backend {name}: "):
        Backend(name).each(operator.neg, ITEMS)


def test_only_dask_has_a_scheduler() -> None:
    with pytest.raises(InputError, match="--backend dask"):
        Backend("loky", "tcp://somewhere:8786")

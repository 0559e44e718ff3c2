"""Where many flights are simulated at once: on this machine's cores, or on a cluster that joblib reaches."""

import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, TypeVar

import joblib
from joblib.parallel import get_active_backend

from companion.errors import InputError

T = TypeVar("T")
R = TypeVar("R")

_ROUND_PER_WORKER = 4
"""Items that a worker gets in one round of a backend that gives its results back all at once."""


@dataclass(frozen=True)
class Backend:
    """A backend of joblib.

    Attributes:
        name: `loky` is one process a core of this machine; `dask`, `ray`, or whatever else joblib knows.
        scheduler: address of Dask's, `tcp://HOST:8786`; Ray has its own in RAY_ADDRESS.

    Raises:
        InputError: a scheduler is given, and the backend has none.
    """

    name: str = "loky"
    scheduler: str | None = None

    def __post_init__(self) -> None:
        if self.scheduler is not None and self.name != "dask":
            raise InputError(f"--scheduler {self.scheduler}: give --backend dask with it")

    def each(self, function: Callable[[T], R], items: Sequence[T]) -> Iterator[R]:
        """`function` of each item, each on one core; results come in the order of the items, as they end.

        Raises:
            InputError: joblib has no such backend, or it cannot be reached.
        """
        tasks = (joblib.delayed(function)(item) for item in items)
        try:
            with self._config(len(items)):
                if get_active_backend()[0].supports_return_generator:
                    return _until_stopped(joblib.Parallel(batch_size=1, return_as="generator")(tasks))
                return _in_rounds(joblib.Parallel(batch_size=1), tasks)
        except (ImportError, OSError, TypeError, ValueError) as error:
            raise InputError(f"--backend {self.name}: {error}") from error

    def _config(self, items: int) -> joblib.parallel_config:
        match self.name:
            case "loky":
                workers = max(1, min(joblib.cpu_count(), items))
                return joblib.parallel_config("loky", n_jobs=workers, inner_max_num_threads=1)
            case "ray":
                from ray.util.joblib import register_ray

                register_ray()
        where = {} if self.scheduler is None else {"scheduler_host": self.scheduler}
        return joblib.parallel_config(self.name, n_jobs=-1, **where)


LOCAL = Backend()
"""All cores of this machine."""


def _until_stopped(results: Generator[R, None, None]) -> Iterator[R]:
    """The results; whoever stops early knows that the rest is cancelled, of which joblib warns."""
    try:
        for result in results:  # noqa: UP028 - `yield from` would close it before the warning is silenced
            yield result
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            results.close()


def _in_rounds(parallel: joblib.Parallel, tasks: Iterable[Any]) -> Iterator[Any]:
    rest = iter(tasks)
    with parallel:
        size = _ROUND_PER_WORKER * joblib.effective_n_jobs(parallel.n_jobs)
        while a_round := list(islice(rest, size)):
            yield from parallel(a_round)

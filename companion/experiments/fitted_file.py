"""A vehicle file with other numbers in it, all else as its author wrote it."""

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedSeq

from companion.experiments.vehicle_parameters import Value
from sitl.estimator_errors import EstimatorErrors

_DIGITS = 4
"""As many as a fit may claim."""


def fitted_file(
    source: Path, values: Mapping[str, Value], estimator: EstimatorErrors | None, remarks: Sequence[str]
) -> str:
    """The text of a vehicle file after a fit; comments and the order of keys stay.

    Args:
        source: the file that the fit began with, a valid one.
        values: by dotted key.
        estimator: what its section of that name shall say; None leaves it as it is.
        remarks: lines of comment at the top.
    """
    yaml = YAML()
    yaml.width = 10_000
    yaml.indent(mapping=2, sequence=4, offset=2)
    document = yaml.load(source.read_text(encoding="utf-8"))
    if estimator is not None:
        document["estimator"] = _plain(estimator.model_dump(exclude_defaults=True))
    for key, value in values.items():
        *sections, name = key.split(".")
        section = document
        for each in sections:
            section = section.setdefault(each, {})
        if isinstance(value, list):
            section[name] = _in_brackets([_rounded(each) for each in value])
        else:
            section[name] = _rounded(value)
    text = io.StringIO()
    yaml.dump(document, text)
    return "".join(f"# {remark}\n" for remark in remarks) + text.getvalue()


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def _in_brackets(values: Sequence[float]) -> CommentedSeq:
    """A list on one line."""
    listed = CommentedSeq(values)
    listed.fa.set_flow_style()
    return listed


def _plain(value: Any) -> Any:
    """A section as this file writes it: lists, which YAML has, for tuples, which it has not."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    return _in_brackets(value) if isinstance(value, tuple) else value

"""The numbers of a vehicle file as parameters that can be varied: by dotted key, within sensible bounds.

`rotors.time_constant_s` is the key `time_constant_s` of the section `rotors`. Where the file has a list, its
mean is varied and the ratios of its elements stay.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from statistics import fmean
from typing import Any, TypeAlias

import numpy as np
from pydantic import ValidationError

from companion.errors import InputError
from sitl.estimator_errors import EstimatorErrors
from sitl.firmware.px4_tuning import tuned_parameters
from sitl.vehicle import Vehicle

SPAN = 4.0
"""A parameter is varied from its start divided by this to its start times this, as far as it may."""

DEFAULT_KEYS = {
    "px4": (
        "rotors.time_constant_s",
        "body_drag.linear_n_s_per_m",
        "px4_parameters.MPC_XY_P",
        "px4_parameters.MPC_XY_VEL_P_ACC",
        "px4_parameters.MPC_Z_P",
        "px4_parameters.MPC_Z_VEL_P_ACC",
    ),
    "ardupilot": (
        "rotors.drag_coefficient_n_s2_per_m",
        "body_drag.linear_n_s_per_m",
        "ardupilot_parameters.PSC_POSXY_P",
        "ardupilot_parameters.PSC_VELXY_P",
        "ardupilot_parameters.PSC_POSZ_P",
        "ardupilot_parameters.PSC_VELZ_P",
    ),
}
"""What is fitted when nothing else is asked for, by firmware: what shows most in how a vehicle tracks."""

Value: TypeAlias = float | list[float]


@dataclass(frozen=True)
class Parameter:
    """A number of a vehicle file: where it starts, and how far it may be varied."""

    key: str
    start: float
    low: float
    high: float


def known_keys(vehicle: Vehicle) -> list[str]:
    """The keys of all numbers that may be varied, those of other firmwares left out; sorted."""
    return sorted(_limits(vehicle))


def parameter(vehicle: Vehicle, key: str) -> Parameter:
    """The parameter of that key.

    Bounds are the file format's own, narrowed to `SPAN` times less or more than the start.

    Raises:
        InputError: no such key, no start value, or no upper bound for one that starts at zero.
    """
    limits = _limits(vehicle)
    if key not in limits:
        raise InputError(f"unknown parameter {key}; there are {', '.join(sorted(limits))}")
    low, high = limits[key]
    value = _at(_complete(vehicle), key)
    if value is None:
        raise InputError(f"{key} has no value to start from: write one into the vehicle's file")
    start = fmean(value) if isinstance(value, tuple | list) else float(value)
    ends = sorted((start / SPAN, start * SPAN))
    low, high = (max(low, ends[0]), min(high, ends[1])) if start else (low, high)
    if not (np.isfinite(low) and np.isfinite(high)):
        raise InputError(
            f"{key} starts at 0, which says nothing of its size: write a guess into the vehicle's file"
        )
    return Parameter(key, start, low, high)


def default_parameters(vehicle: Vehicle) -> tuple[Parameter, ...]:
    """Those of `DEFAULT_KEYS` that have something to start from."""
    found = []
    for key in DEFAULT_KEYS[vehicle.firmware]:
        try:
            found.append(parameter(vehicle, key))
        except InputError:
            continue
    return tuple(found)


def with_values(vehicle: Vehicle, values: Mapping[str, float]) -> Vehicle:
    """The vehicle with other values.

    Raises:
        InputError: no vehicle file may say so, in these values or in their combination.
    """
    document = vehicle.model_dump(exclude_unset=True)
    for key, value in file_values(vehicle, values).items():
        *sections, name = key.split(".")
        section = document
        for each in sections:
            section = section.setdefault(each, {})
        section[name] = value
    try:
        return Vehicle.model_validate(document)
    except ValidationError as error:
        raise InputError(error.errors(include_url=False)[0]["msg"]) from None


def file_values(vehicle: Vehicle, values: Mapping[str, float]) -> dict[str, Value]:
    """What the vehicle's file is to say: numbers as they are, lists in the ratio of their elements."""
    document = _complete(vehicle)
    return {key: _in_place_of(_at(document, key), value) for key, value in values.items()}


def _in_place_of(old: Any, value: float) -> Value:
    if not isinstance(old, tuple | list):
        return value
    mean = fmean(old)
    return [value * each / mean if mean else value for each in old]


def _complete(vehicle: Vehicle) -> dict[str, Any]:
    """All keys with the values that act, also where the file leaves them out."""
    document = vehicle.model_dump()
    document["estimator"] = (vehicle.estimator or EstimatorErrors()).model_dump()
    if vehicle.firmware == "px4":
        document["px4_parameters"] = tuned_parameters(vehicle).model_dump()
    return document


def _at(document: Mapping[str, Any], key: str) -> Any:
    value: Any = document
    for name in key.split("."):
        value = value[name]
    return value


def _limits(vehicle: Vehicle) -> dict[str, tuple[float, float]]:
    """Least and greatest value of each key, as the file format has them.

    The estimator's noise is left out, since a twin that is compared flies without it.
    """
    schema = Vehicle.model_json_schema()
    foreign = tuple(f"{name}_parameters." for name in DEFAULT_KEYS if name != vehicle.firmware)

    def may_be_varied(key: str) -> bool:
        return not key.startswith(foreign) and (not key.startswith("estimator.") or key.endswith(".delay_s"))

    return {key: limits for key, limits in _numbers(schema, schema["$defs"], "") if may_be_varied(key)}


def _numbers(
    schema: Mapping[str, Any], definitions: Mapping[str, Any], key: str
) -> Iterator[tuple[str, tuple[float, float]]]:
    """The numbers beneath a part of a JSON schema; of a list of numbers its first stands for all."""
    if "$ref" in schema:
        schema = definitions[schema["$ref"].rpartition("/")[2]]
    if "anyOf" in schema:  # a number or nothing, a number or a list: the first is what can be varied
        schema = schema["anyOf"][0]
        yield from _numbers(schema, definitions, key)
    elif "prefixItems" in schema:
        yield from _numbers(schema["prefixItems"][0], definitions, key)
    elif "properties" in schema:
        for name, part in schema["properties"].items():
            yield from _numbers(part, definitions, f"{key}.{name}" if key else name)
    elif schema.get("type") == "number":
        low = schema.get("minimum", schema.get("exclusiveMinimum", -np.inf))
        yield key, (low, schema.get("maximum", schema.get("exclusiveMaximum", np.inf)))

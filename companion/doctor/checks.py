"""All checks: from what was seen to what it means for a flight."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeAlias

from companion.doctor import ardupilot_rules, link_checks, px4_rules, vehicle_checks
from companion.doctor.finding import Finding, warns
from companion.doctor.observation import Observation
from companion.doctor.rule import Rule

Check: TypeAlias = Callable[[Observation], Iterable[Finding]]

RULES: Mapping[str, Mapping[str, Rule]] = {"PX4": px4_rules.RULES, "ArduPilot": ardupilot_rules.RULES}
"""By the autopilot's name: the parameters that matter, and what to make of them."""


def _parameters(seen: Observation) -> Iterator[Finding]:
    """What the autopilot would do of itself, by its parameters."""
    rules = RULES.get(seen.identity.autopilot, {})
    if rules and not seen.parameters:
        told = "it answers for none of them: what it does when setpoints stop is not known"
        yield warns("parameters", told, "check that it hears us, and that its version is a supported one")
    for name, rule in rules.items():
        value = seen.parameters.get(name)
        if value is None:
            continue
        if math.isfinite(value):
            yield rule(name, value, seen)
        else:
            yield warns(name, f"{value}, which is no value", f"set {name} to its default")


CHECKS: tuple[Check, ...] = (
    vehicle_checks.identity,
    vehicle_checks.mode,
    vehicle_checks.estimator,
    vehicle_checks.position_sources,
    vehicle_checks.arming,
    vehicle_checks.battery,
    link_checks.rates,
    link_checks.loss,
    link_checks.latency,
    link_checks.signing,
    link_checks.others,
    _parameters,
)


def judge(seen: Observation) -> list[Finding]:
    """What each check makes of it, in the order of the report."""
    return [finding for check in CHECKS for finding in check(seen)]

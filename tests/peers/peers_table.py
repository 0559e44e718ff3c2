"""What each client can do with each autopilot, as a table of the tests and their outcomes.

Usage: python tests/peers/peers_table.py JUNIT_XML MARKDOWN
"""

import sys
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from xml.etree import ElementTree

import test_peers
from peering import DRONEKIT, MAVPROXY, MAVSDK, PYMAVLINK, Pair

PAIRS = [pair for client in (MAVSDK, PYMAVLINK, MAVPROXY, DRONEKIT) for pair in sorted(client, reverse=True)]
NOT_OFFERED = "—"


def features() -> dict[str, frozenset[Pair]]:
    """The pairs that each feature is tested with."""
    tests = {name: test for name, test in vars(test_peers).items() if name.startswith("test_")}
    return {feature_name(name): frozenset(test.pytestmark[0].args[1]) for name, test in tests.items()}


def feature_name(test: str) -> str:
    return test.removeprefix("test_").replace("_", " ")


def versions() -> dict[str, str]:
    """The version of each client that the tests install."""
    pins = {}
    for name in ("mavproxy", "dronekit"):
        lines = (Path(__file__).parent / f"{name}.txt").read_text().splitlines()
        pins[name] = next(line.partition("==")[2] for line in lines if line.lower().startswith(name))
    return pins | {name: version(name) for name in ("mavsdk", "pymavlink")}


def outcomes(junit: Path) -> dict[tuple[str, str], bool]:
    """Whether each feature's test passed, by feature and pair."""
    found = {}
    for case in ElementTree.parse(junit).iter("testcase"):
        test, _, pair = case.get("name", "").rstrip("]").partition("[")
        if pair:
            found[feature_name(test), pair] = case.find("failure") is None and case.find("error") is None
    return found


def table(passed: Mapping[tuple[str, str], bool]) -> list[str]:
    """The lines of the table."""
    heads = [f"{pair.client} {versions()[pair.client]}, {pair.autopilot}" for pair in PAIRS]
    rows = [["feature", *heads], ["-"] * (1 + len(PAIRS))]
    for feature, pairs in features().items():
        cells = (
            ("yes" if passed[feature, str(pair)] else "no") if pair in pairs else NOT_OFFERED
            for pair in PAIRS
        )
        rows.append([feature, *cells])
    return [f"| {' | '.join(row)} |" for row in rows]


def rewrite(markdown: Path, lines: list[str]) -> None:
    """Put the lines in the place of the table in a file."""
    old = markdown.read_text().splitlines()
    rows = [number for number, line in enumerate(old) if line.startswith("|")]
    markdown.write_text("\n".join([*old[: rows[0]], *lines, *old[rows[-1] + 1 :], ""]))


if __name__ == "__main__":
    rewrite(Path(sys.argv[2]), table(outcomes(Path(sys.argv[1]))))

import json
import math
from pathlib import Path

import pytest

from companion.cli.result_file import write_result


def test_results_are_strict_json(tmp_path: Path) -> None:
    file = tmp_path / "result.json"
    write_result({"a": [1, math.nan, (math.inf, "x")], "b": {"c": -math.inf, "d": 0.5, "e": True}}, file)

    def refuse(constant: str) -> None:
        pytest.fail(f"{constant} is no JSON")

    told = json.loads(file.read_text(), parse_constant=refuse)
    assert told == {"a": [1, None, [None, "x"]], "b": {"c": None, "d": 0.5, "e": True}}

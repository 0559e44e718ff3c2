"""The demo, on one drawing."""

import re
from pathlib import Path

import pytest
from early_network import early_network

from companion.experiments import demo, lookahead
from companion.experiments.contenders import Model
from companion.flight.strategies import Strategy


def test_table_and_report_with_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(lookahead, "FLIGHT_S", 20.0)
    monkeypatch.setattr(demo, "DRAWINGS", ("clef",))
    monkeypatch.setattr(demo, "find_model", lambda name, online: Model(name, early_network()))
    demo.demo(output=tmp_path / "report", conditions="ideal", seed=1)
    shown = capsys.readouterr().out
    for strategy in Strategy:
        assert strategy in shown
    assert str(tmp_path / "report" / "index.html") in shown.replace("\n", "")
    page = (tmp_path / "report" / "index.html").read_text(encoding="utf-8")
    pictures = re.findall(r'src="([^"]+)"', page)
    assert len(pictures) == 3
    assert all((tmp_path / "report" / picture).is_file() for picture in pictures)
    assert "--seed 1" in page


def test_every_strategy_is_explained() -> None:
    assert set(demo.LEGEND) == set(Strategy)

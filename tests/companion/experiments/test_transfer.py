"""`companion bench transfer`: its figures from rows that are made up, and a job that is stopped."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from early_network import early_network
from typer.testing import CliRunner

from companion.cli import resumed
from companion.cli.app import app
from companion.errors import InputError
from companion.experiments.contenders import Model
from companion.experiments.journal import Journal
from companion.experiments.trajectories import courses
from companion.experiments.transfer import Transfer, TransferRow, figures, pair_table, summary
from companion.trajectory.placement import Placement

MODELS = {name: Model(name, early_network(vehicle=name)) for name in ("ardrone2", "bebop2", "iris")}


@pytest.fixture
def line(tmp_path: Path) -> Path:
    file = tmp_path / "line.csv"
    file.write_text("t,x,y,z\n0,0,0,2\n1,0.2,0,2\n2,0.5,0,2.2\n")
    return file


def row(source: str | None, strategy: str, rms_m: float | None, target: str = "bebop2") -> TransferRow:
    return TransferRow(
        vehicle=target,
        strategy=strategy,
        model=source,
        conditions="ideal",
        trajectory="A",
        plane="xz",
        speed_m_s=None,
        reached_m_s=1.2,
        rms_m=rms_m,
        source=source,
        target=target,
    )


def flown(*rms_m: float | None, baseline_m: float | None = 0.4) -> list[TransferRow]:
    return [
        row(None, "baseline", baseline_m),
        row(None, "gp", 0.1),
        *(row("ardrone2", "dnn+gp", each) for each in rms_m),
    ]


def test_the_summary_is_over_the_flights_with_a_network() -> None:
    told = summary(flown(0.04, 0.1))
    assert told.flights == 2
    assert told.mean_reduction == pytest.approx((0.9 + 0.75) / 2)
    assert told.worst_ratio == pytest.approx(0.25)
    assert told.worse_than_baseline == 0


@pytest.mark.parametrize(
    ("baseline_m", "rms_m", "is_worse"),
    [(0.4, 0.419, 0), (0.4, 0.421, 1), (0.1, 0.109, 0), (0.1, 0.111, 1), (0.4, None, 1), (None, 9.0, 0)],
)
def test_harm_is_more_than_five_percent_and_a_centimetre(
    baseline_m: float | None, rms_m: float | None, is_worse: int
) -> None:
    assert summary(flown(rms_m, baseline_m=baseline_m)).worse_than_baseline == is_worse


def test_without_anything_to_compare_there_is_no_reduction() -> None:
    told = summary(flown(0.1, baseline_m=None))
    assert (told.flights, told.mean_reduction, told.worst_ratio) == (1, None, None)


def test_each_row_tells_gp_beside() -> None:
    rows = figures(flown(0.04))["rows"]
    assert [each["gp_rms_m"] for each in rows] == [0.1, 0.1, 0.1]
    assert [each["source"] for each in rows] == [None, None, "ardrone2"]


def test_a_pair_that_was_not_flown_is_an_empty_cell() -> None:
    table = pair_table([*flown(0.1), row(None, "baseline", 0.3, target="ardrone2")], "ideal")
    assert [list(column.cells) for column in table.columns[1:]] == [["", "0.75 (0.25)"], ["–", ""]]


def test_baseline_and_gp_fly_once_for_all_sources(line: Path) -> None:
    drawings, _ = courses([str(line)], Placement(), list(MODELS))
    job = Transfer(MODELS, ["ideal", "px4"], drawings)
    flights = job.flights()
    assert len(flights) == 2 * 3 * (2 + 2)
    assert (
        len({(f.scenario.conditions, f.scenario.vehicle, f.source, f.contender.strategy) for f in flights})
        == 24
    )
    assert all(f.source != f.scenario.vehicle for f in flights)


def test_the_fingerprint_is_that_of_this_job(line: Path) -> None:
    drawings, _ = courses([str(line)], Placement(), list(MODELS))
    job = Transfer(MODELS, ["ideal"], drawings)
    others = [
        replace(job, seed=1),
        replace(job, conditions=["px4"]),
        replace(job, models=dict(list(MODELS.items())[:2])),
        replace(job, models=MODELS | {"iris": Model("iris", early_network(0.3, "iris"))}),
        replace(job, courses=courses([str(line)], Placement(), list(MODELS), [0.2])[0]),
    ]
    assert job.fingerprint() == replace(job).fingerprint()
    assert len({each.fingerprint() for each in [job, *others]}) == len(others) + 1


def bench(*arguments: str | Path) -> str:
    result = CliRunner().invoke(app, ["bench", "transfer", *map(str, arguments)])
    if result.exception is not None:
        raise result.exception
    return result.output


class Interrupted(Journal[TransferRow]):
    """Is stopped after its fourth row."""

    def append(self, row: TransferRow) -> None:
        super().append(row)
        if len(self.rows) == 4:
            raise KeyboardInterrupt


def test_what_was_flown_before_a_stop_is_not_flown_again(
    line: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments = ["--vehicles", "ardrone2", "bebop2", "--conditions", "ideal", "--trajectories", str(line)]
    file, kept = tmp_path / "stopped.json", tmp_path / "stopped.json.flown"
    with monkeypatch.context() as patch:
        patch.setattr(resumed, "Journal", Interrupted)
        with pytest.raises(SystemExit):
            bench(*arguments, "--json", file)
    assert not file.exists()
    before = [json.loads(line)["rms_m"] for line in kept.read_text().splitlines()[1:]]
    with pytest.raises(InputError, match="other settings"):
        bench(*arguments, "--seed", "1", "--json", file)
    assert "4 of 6 parts" in bench(*arguments, "--json", file)
    assert not kept.exists()
    told = json.loads(file.read_text())
    assert set(told) == {"rows", "summary", "by_conditions", "settings", "notes", "software"}
    assert [row["rms_m"] for row in told["rows"][:4]] == before
    assert [row["source"] for row in told["rows"]] == [None, None, "bebop2", None, None, "ardrone2"]
    assert set(told["summary"]) == {"mean_reduction", "worst_ratio", "flights", "worse_than_baseline"}
    assert told["summary"]["flights"] == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--vehicles", "bebop2"], "at least two"),
        (["--vehicles", "bebop2", "zeppelin"], "zeppelin"),
        (["--conditions", "stormy", "--trajectories", "Leaf_1"], "stormy"),
    ],
)
def test_wrong_use_is_one_line(arguments: list[str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        bench(*arguments)

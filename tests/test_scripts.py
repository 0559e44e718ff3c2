"""The set-up: what is installed and when, what is said when it cannot be, and that the pins fit."""

import os
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

ROOT = Path(__file__).parents[1]


def executable(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


def shell(root: Path, command: str, path: Path | None = None) -> subprocess.CompletedProcess[str]:
    search = f"{path}:{os.environ['PATH']}" if path else os.environ["PATH"]
    script = f'set -euo pipefail; source "$1/scripts/environment.sh"; {command}'
    return subprocess.run(
        ["bash", "-c", script, "bash", root],
        capture_output=True,
        text=True,
        env={"PATH": search},
        check=False,
    )


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """A copy of what the set-up reads, whose Python only notes how pip was called."""
    root = tmp_path / "a repository"
    (root / "scripts").mkdir(parents=True)
    for name in ("scripts/environment.sh", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, root / name)
    executable(root / ".venv/bin/python", f'case "$2" in pip) echo "$*" >>"{tmp_path}/calls" ;; esac')
    return root


def installed(repository: Path) -> list[str]:
    """The extras of each call of pip so far."""
    calls = repository.parent / "calls"
    return re.findall(r"\[(.*)\]", calls.read_text()) if calls.exists() else []


def test_only_what_is_missing_is_installed(repository: Path) -> None:
    for _ in range(2):
        assert shell(repository, "prepare sim bench").returncode == 0
    assert installed(repository) == ["sim,bench"]
    shell(repository, "prepare bench dev")
    assert installed(repository) == ["sim,bench", "dev"]
    with (repository / "constraints.txt").open("a") as constraints:
        constraints.write("# newer\n")
    shell(repository, "prepare sim bench")
    assert installed(repository) == ["sim,bench", "dev", "sim,bench"]


def test_torch_comes_without_cuda_where_its_index_answers(repository: Path) -> None:
    shell(repository, "prepare dev train")
    assert (
        "--extra-index-url=https://download.pytorch.org/whl/cpu" in (repository.parent / "calls").read_text()
    )
    unreachable = (
        (repository / ".venv/bin/python").read_text().replace("#!/bin/sh\n", '[ "$1" != - ] || exit 1\n')
    )
    executable(repository / ".venv/bin/python", unreachable)
    (repository.parent / "calls").unlink()
    (repository / ".venv/impromptu-train").unlink()
    shell(repository, "prepare dev train")
    assert installed(repository) == ["train"]
    assert "index" not in (repository.parent / "calls").read_text()


def test_a_failed_installation_is_tried_again(repository: Path) -> None:
    noting = (repository / ".venv/bin/python").read_text().removeprefix("#!/bin/sh\n")
    executable(repository / ".venv/bin/python", f'{noting}\n[ "$2" != pip ]')
    assert shell(repository, "prepare sim").returncode != 0
    assert shell(repository, "prepare sim").returncode != 0
    assert installed(repository) == ["sim", "sim"]


def test_each_peer_is_installed_once_for_each_list_of_its_packages(repository: Path) -> None:
    shutil.copytree(ROOT / "tests/peers", repository / "tests/peers")
    calls = repository.parent / "calls"
    makes_venvs = f"""case "$2" in
        venv) mkdir -p "$3/bin" && cp "$0" "$3/bin/python" ;;
        pip) echo "$*" >>"{calls}" ;;
    esac"""
    executable(repository / ".venv/bin/python", makes_venvs)
    for _ in range(2):
        assert shell(repository, "prepare_peers").returncode == 0
    assert len(calls.read_text().splitlines()) == 2
    with (repository / "tests/peers/dronekit.txt").open("a") as packages:
        packages.write("# newer\n")
    shell(repository, "prepare_peers")
    assert [line.rpartition("/")[2] for line in calls.read_text().splitlines()] == [
        "mavproxy.txt",
        "dronekit.txt",
        "dronekit.txt",
    ]


def test_without_venv_the_line_to_type_is_printed(tmp_path: Path) -> None:
    executable(tmp_path / "python3", 'case "$2" in *ensurepip*) exit 1 ;; esac')
    for version in ("3.11", "3.12", "3.13"):
        executable(tmp_path / f"python{version}", "exit 1")
    result = shell(ROOT, "find_python", path=tmp_path)
    assert result.returncode != 0
    assert "    sudo apt install python3-venv\n" in result.stderr


def test_a_python_that_does_not_run_is_passed_over(tmp_path: Path) -> None:
    executable(tmp_path / "python3", "exit 127")
    executable(tmp_path / "python3.13", "exit 127")
    executable(tmp_path / "python3.12", "exit 0")
    assert shell(ROOT, "find_python", path=tmp_path).stdout == "python3.12\n"


def test_without_any_python_the_line_to_type_is_printed(tmp_path: Path) -> None:
    for version in ("3", "3.11", "3.12", "3.13"):
        executable(tmp_path / f"python{version}", "exit 1")
    result = shell(ROOT, "find_python", path=tmp_path)
    assert result.returncode != 0
    assert "    sudo apt install python3 python3-venv\n" in result.stderr


def test_every_dependency_is_pinned_within_its_range() -> None:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pins = dict(line.split("==") for line in lines if not line.startswith("#"))
    versions = {name.lower().replace("_", "-"): Version(version) for name, version in pins.items()}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    for requirement in (Requirement(text) for group in groups for text in group):
        if requirement.name != project["name"]:
            assert versions[requirement.name.lower()] in requirement.specifier, requirement

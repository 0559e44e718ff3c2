import json
from pathlib import Path

from command_line import Run

from companion.cli.resumed import journal_of
from companion.experiments.fuzz.job import belongs_to, blocks
from companion.experiments.fuzz.row import FuzzRow
from companion.experiments.journal import Journal


def test_the_command_writes_its_figures(companion: Run, tmp_path: Path) -> None:
    file = tmp_path / "fuzz.json"
    ran = companion("bench", "fuzz", "--frames", 640, "--files", 0, "--json", file)
    assert ran.status == 0, ran.err
    told = json.loads(file.read_text())
    assert (told["inputs"], told["lost"], told["faults"]) == (640, 0, 0)
    assert not journal_of(file).exists()


def test_a_job_goes_on_where_it_was_stopped_and_tells_what_failed(companion: Run, tmp_path: Path) -> None:
    file = tmp_path / "fuzz.json"
    todo = blocks(640, 0, seed=0)
    journal = Journal(journal_of(file), FuzzRow, belongs_to=belongs_to(todo), most=len(todo))
    journal.append(FuzzRow(reader="link", inputs=640, faults=("KeyError at a.py:1: 3",)))
    ran = companion("bench", "fuzz", "--frames", 640, "--files", 0, "--json", file)
    assert ran.status == 1
    assert "1 of 1 parts were done before" in ran.out
    assert "link: KeyError at a.py:1: 3" in ran.out

"""The command line, run in this process."""

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import Ran, Run

from companion.cli import main


@pytest.fixture
def companion(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Iterator[Run]:
    monkeypatch.setenv("IMPROMPTU_LOG_DIR", str(tmp_path / "flights"))

    def run(*arguments: object) -> Ran:
        monkeypatch.setattr("sys.argv", ["companion", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        said = capsys.readouterr()
        status = ended.value.code
        assert isinstance(status, int)
        return Ran(status, said.out, said.err)

    yield run
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)

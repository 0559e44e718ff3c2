"""What no source of ours may do with what comes from outside: docs/security.md, read from the sources."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from sitl.endpoints import ENDPOINTS

ROOT = Path(__file__).parent.parent
SOURCES = [path.relative_to(ROOT) for room in ("companion", "sitl") for path in (ROOT / room).rglob("*.py")]
RUN_CODE_MODULES = {
    "pickle",
    "cPickle",
    "dill",
    "cloudpickle",
    "marshal",
    "shelve",
    "subprocess",
    "pty",
    "code",
}
RUN_CODE_CALLS = {
    *("eval", "exec", "compile", "__import__", "os.system", "os.popen", "os.execv", "os.spawnv"),
    *("torch.load", "joblib.load", "yaml.unsafe_load", "yaml.full_load", "yaml.unsafe_load_all"),
}
SAFE_LOADERS = {"_Loader", "yaml.SafeLoader"}
MAY_READ_ALL = (
    "companion/cli/options.py",  # the digest of model files that were read, and so bounded, before
    "companion/cli/thermometer.py",  # /sys
    "companion/cli/unfinished.py",  # notes of our own
    "companion/experiments/",  # files of our own, and results
    "companion/recording/mcap_reader.py",  # from memory
    "sitl/compiled.py",  # our own sources
)
MAY_OPEN_SOCKETS = {
    "companion/link/udp.py",
    "companion/link/tcp.py",
    "companion/experiments/loaded.py",
    "sitl/sockets.py",
}
OPEN_SOCKETS = {"create_server", "start_server", "create_datagram_endpoint", "bind", "serve_forever"}


def calls(path: Path) -> Iterator[ast.Call]:
    tree = ast.parse((ROOT / path).read_text())
    return (node for node in ast.walk(tree) if isinstance(node, ast.Call))


def imported(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse((ROOT / path).read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module.partition(".")[0]


@pytest.mark.parametrize("path", SOURCES, ids=str)
def test_nothing_that_is_read_becomes_code(path: Path) -> None:
    assert not RUN_CODE_MODULES & set(imported(path))
    for call in calls(path):
        name = ast.unparse(call.func)
        assert name not in RUN_CODE_CALLS
        options = {option.arg: ast.unparse(option.value) for option in call.keywords}
        assert "shell" not in options
        assert options.get("allow_pickle", "False") == "False"
        if name == "yaml.load" and len(call.args) > 1:
            assert ast.unparse(call.args[1]) in SAFE_LOADERS


def methods_called(path: Path) -> Iterator[tuple[str, int]]:
    """The names of methods and functions of modules, and how many arguments each is given."""
    for call in calls(path):
        if isinstance(call.func, ast.Attribute):
            yield call.func.attr, len(call.args)


def test_no_file_is_read_without_a_bound() -> None:
    for path in SOURCES:
        if not str(path).startswith(MAY_READ_ALL):
            methods = set(methods_called(path))
            assert not methods & {("read_text", 0), ("read_bytes", 0), ("readlines", 0), ("read", 0)}, path


def test_only_links_open_sockets() -> None:
    for path in SOURCES:
        opened = {name for name, _ in methods_called(path)} & OPEN_SOCKETS
        assert not opened or str(path) in MAY_OPEN_SOCKETS, path


@pytest.mark.parametrize("firmware", ENDPOINTS)
def test_a_simulated_vehicle_listens_to_this_machine_unless_its_peer_is_on_another(firmware: str) -> None:
    assert {endpoint.host for endpoint in ENDPOINTS[firmware](1, "127.0.0.1")} == {"127.0.0.1"}
    assert {endpoint.host for endpoint in ENDPOINTS[firmware](1, "10.0.0.2")} == {"0.0.0.0"}

"""docs/peers.md says of each feature and pair what the tests have."""

from peering import ROOT
from peers_table import NOT_OFFERED, PAIRS, features, table


def test_the_table_lists_what_the_tests_have() -> None:
    lines = [line for line in (ROOT / "docs/peers.md").read_text().splitlines() if line.startswith("|")]
    expected = table({(feature, str(pair)): True for feature in features() for pair in PAIRS})
    assert lines[:2] == expected[:2], "run scripts/peers-table: clients or their versions have changed"
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]
    assert [row[0] for row in cells] == list(features()), "run scripts/peers-table: features have changed"
    for row, pairs in zip(cells, features().values(), strict=True):
        offered = {pair for pair, cell in zip(PAIRS, row[1:], strict=True) if cell != NOT_OFFERED}
        assert offered == pairs, f"run scripts/peers-table: who offers {row[0]!r} has changed"

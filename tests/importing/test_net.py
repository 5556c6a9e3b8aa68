"""What import makes of files of all kinds stays what the table says, cell by cell."""

import pytest

from tests.importing.net import changed, counted, drawn, read


@pytest.mark.parametrize("every", [20, pytest.param(1, marks=[pytest.mark.slow])])
def test_imports_change_only_with_their_table(every: int) -> None:
    """`python -m tests.importing.net` writes it anew; its changed cells belong into a commit."""
    assert changed(drawn(every=every), read()) == []


def test_nothing_proven_is_wrong() -> None:
    assert counted(read())["wrong, proven"] == 0

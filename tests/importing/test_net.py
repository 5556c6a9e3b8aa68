"""What import makes of files of all kinds stays what the table says, cell by cell."""

import pytest

from tests.importing.net import changed, counted, drawn, read
from tests.importing.test_import_random_forms import MARKED, REFUSED, RIGHT


@pytest.mark.parametrize("every", [20, pytest.param(1, marks=[pytest.mark.slow])])
def test_imports_change_only_with_their_table(every: int) -> None:
    """`python -m tests.importing.net` writes it anew; its changed cells belong into a commit."""
    assert changed(drawn(every=every), read()) == []


@pytest.mark.parametrize(("sure", "most"), [("proven", 0.0), ("assumed", 0.02)])
def test_what_is_proven_or_assumed_is_right(sure: str, most: float) -> None:
    """Of all cells with a truth: none of the proven, and fewer than one in 50 of the assumed."""
    table = read()
    states = counted(table[table["sure"] == sure])
    assert states["right"] > 100
    assert states[f"wrong, {sure}"] <= most * states.total()


def test_no_random_form_is_silently_wrong() -> None:
    forms = {name for name in counted(read()) if name.startswith("random form ")}
    assert forms <= {f"random form {result}" for result in (RIGHT, MARKED, REFUSED)}

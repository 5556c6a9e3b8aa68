"""What `ur5 payload` says of a mass, from rows of the table with a known answer."""

import re

import pandas as pd
import pytest

from ur5lib.commands.answers import _carried

NOTHING = pd.DataFrame(columns=["quantity"])


def said(mass: float, low: float, high: float, configured: float = 0.0) -> str:
    row = {"mass": mass, "low": low, "high": high, "configured": configured}
    row |= {"center_of_mass_x": float("nan")}
    (told,) = _carried(pd.DataFrame([row]), NOTHING)
    return told.partition(", configured")[0]


@pytest.mark.parametrize(
    ("found", "numbers"),
    [
        ((-0.16, -0.29, -0.02), ["0.29"]),
        ((0.02, -0.01, 0.05), ["0.05"]),
        ((0.0, -147.65, 147.65), ["148"]),
        ((2.78, 2.60, 2.95), ["2.78", "2.60", "2.95"]),
        ((-0.16, -0.29, -0.02, 0.5), ["0.34", "0.21", "0.48"]),
    ],
)
def test_a_mass_is_never_negative(found: tuple[float, ...], numbers: list[str]) -> None:
    told = said(*found)
    assert re.findall(r"[-−]?\d[\d.]*", told) == numbers


def test_a_mass_that_nothing_determines_is_not_called_no_load() -> None:
    assert "do not determine" in said(0.0, -147.65, 147.65)
    assert "no certain load" in said(-0.16, -0.29, -0.02)

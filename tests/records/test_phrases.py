"""Numbers and lists in sentences."""

import math

import pytest

from ur5lib.errors import overrulable
from ur5lib.records.phrases import as_written, number, numbered


@pytest.mark.parametrize(
    ("value", "text"), [(1.5e-8, "0.000000015"), (12345.0, "12300"), (2.0, "2"), (-0.3, "−0.3")]
)
def test_no_number_has_an_exponent(value: float, text: str) -> None:
    assert number(value, ".3g") == text


def test_a_number_without_bounds_has_four_digits() -> None:
    """Torques beside a column of zeros differ by any share."""
    assert number(1e300, ".0%") == "above 9999%"
    assert number(0.4, ".0%") == "40%"
    assert number(-2e7, "+.0f") == "below −9999"
    assert number(-0.5, "+.2%") == "−50.00%"


@pytest.mark.parametrize("value", [None, math.nan, math.inf])
def test_what_is_no_number_is_unknown(value: float | None) -> None:
    assert number(value, ".3g") == "unknown"


def test_a_list_of_numbers_is_as_a_study_writes_it() -> None:
    assert as_written([0.0, 0.0, -9.81], "g") == "0, 0, -9.81"


def test_one_joint_is_no_joints() -> None:
    assert [numbered(some) for some in ([4], [2, 3])] == ["joint 4", "joints 2, 3"]


def test_a_stop_sign_says_how_a_study_overrules_it() -> None:
    told = "joints 1 and 2 are exchanged; if the study is right, `accept: {order: the reason}`"
    assert overrulable("joints 1 and 2 are exchanged", "order") == f"{told} overrules this"
    assert overrulable("it has no rows", "") == "it has no rows"

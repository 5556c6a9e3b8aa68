"""Reasons of verdicts in words."""

import math

import pytest

from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.records.verdicts import REASONS, reason_in_words


@pytest.mark.parametrize("effort", [CURRENT, TORQUE])
@pytest.mark.parametrize("code", REASONS)
def test_each_reason_is_a_sentence_of_the_arm_s_effort(code: str, effort: Effort) -> None:
    sentence = reason_in_words(code, effort)
    assert sentence[0].isupper()
    assert sentence.endswith(".")
    assert not {*sentence} & {*"{}_"}
    assert "{constant}" not in REASONS[code] or effort.constant in sentence


def test_an_empty_cell_has_no_reason_and_an_unknown_one_stays_a_code() -> None:
    assert reason_in_words(math.nan) == reason_in_words("") == ""
    assert reason_in_words("{later}\x1b") == r"{later}\x1b"

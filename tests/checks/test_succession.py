"""What a study says of the recording before, beside where that ended."""

import numpy as np
import pytest

from ur5lib.checks.succession import moved_between, stated_succession


@pytest.mark.parametrize("joint", [0, 3, 6])
@pytest.mark.parametrize("sign", [-1, 1])
def test_an_arm_that_was_moved_in_between_is_told_with_its_joint(joint: int, sign: int) -> None:
    rest = np.full(7, 5e-5)
    assert moved_between("first", rest) is None
    assert stated_succession("first", rest).confidence == "proven"
    moved = rest + sign * 0.02 * np.eye(7)[joint]
    found = moved_between("first", moved)
    assert found is not None
    assert found.joints == (joint + 1,)
    assert "`after`" in found.sentence()
    assert stated_succession("first", moved).confidence == "check"

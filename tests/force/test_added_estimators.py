"""Estimators that an extension adds: which are refused, and what they may state."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from ur5lib.errors import InputError
from ur5lib.force import estimators
from ur5lib.force.estimators import Estimator, Run, Stated, added, checked

RUN = cast(Run, SimpleNamespace(motion=SimpleNamespace(time=np.arange(5.0))))
WRENCH, ODDS = np.zeros((5, 6)), np.zeros(5)


def plain(found: Any, gated: bool = False) -> Estimator:
    return Estimator("plain", lambda _: found, gated)


@pytest.mark.parametrize(
    ("name", "one", "told"),
    [
        ("ours", plain(None), ""),
        ("Ours", plain(None), "rename it"),
        ("shipped", plain(None), "rename it"),
        ("ours", "plain", "is no Estimator"),
    ],
)
def test_an_estimator_has_a_lower_case_name_of_its_own(
    name: str, one: Any, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(estimators, "additions", lambda _: [("own.py", name, one)])
    if not told:
        assert [*added(["shipped"])] == [name]
        return
    with pytest.raises(InputError, match=told):
        added(["shipped"])


@pytest.mark.parametrize(
    ("found", "gated", "told"),
    [
        (Stated(WRENCH), False, ""),
        (Stated(WRENCH, WRENCH, ODDS), True, ""),
        (None, True, ""),
        (Stated(WRENCH), True, "no `log_odds`"),
        (Stated(WRENCH[1:]), False, r"a \(4, 6\) `wrench`"),
        (Stated(WRENCH, WRENCH[:, :3]), False, r"a \(5, 3\) `std`"),
        (Stated(WRENCH, None, WRENCH), True, r"a \(5, 6\) `log_odds`"),
    ],
)
def test_an_estimator_states_all_samples(found: Stated | None, gated: bool, told: str) -> None:
    """And has odds of contact only if alarms are raised by them."""
    if not told:
        assert checked(plain(found, gated), "own.py: 'ours'", RUN) is found
        return
    with pytest.raises(InputError, match=told):
        checked(plain(found, gated), "own.py: 'ours'", RUN)

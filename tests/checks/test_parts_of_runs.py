"""Recordings of one run: halves, of which a fitted one leaves none unseen, and copies."""

from dataclasses import replace
from itertools import product

import numpy as np
import pandas as pd
import pytest

from ur5lib.checks.files import findings, name_copies, spare_copies
from ur5lib.checks.parts_of_runs import Ends, as_text
from ur5lib.records.codes import Found
from ur5lib.records.quality import Quality
from ur5lib.tables import named

STEP = 0.01
TIME = STEP * np.arange(1000)


def part(start: int, end: int, shift: float = 0.0, epoch: float | None = None) -> Quality:
    """A part of a motion that rests in the middle, its stamps later by a shift [s]."""
    q = np.cos(np.where(TIME < 5, TIME, np.maximum(5, TIME - 1)))[:, None] * [1.0, -0.5, 2.0]
    rows = slice(start, end)
    robot = pd.DataFrame({"time": TIME[rows] + shift}).assign(**named(q[rows], "actual_q"))
    quality = Quality(period_s=STEP, start_epoch_s=epoch)
    return replace(quality, ends=as_text(Ends.of(robot, quality)))


def found_of(parts: dict[str, Quality]) -> pd.DataFrame:
    rows = [
        {"recording": name, "device": "robot", "code": one.code, "finding": one.code.words}
        | {"severity": one.severity, "count": one.count, "detail": one.detail}
        for name, own in parts.items()
        for one in findings(own)
    ]
    return pd.DataFrame(rows)


def noted(roles: dict[str, str], **parts: Quality) -> list[str]:
    found = name_copies(found_of(parts), roles)
    return found.loc[found["code"] == Found.PARTS_OF_ONE_RUN, "recording"].tolist()


@pytest.mark.parametrize("role", ["validate", "contact"])
@pytest.mark.parametrize("cut", [300, 550])
def test_the_half_that_is_not_fitted_is_noted(role: str, cut: int) -> None:
    """Wherever the run is cut, also at rest, where the clock goes on."""
    first, second = part(0, cut), part(cut, 1000)
    assert noted({"a": "fit", "b": role}, a=first, b=second) == ["b"]
    assert noted({"a": role, "b": "fit"}, a=first, b=second) == ["a"]
    assert noted({"a": "fit", "b": "fit"}, a=first, b=second) == []


def test_files_without_one_clock_are_parts_where_motion_goes_on() -> None:
    roles, first = {"a": "fit", "b": "validate"}, part(0, 300)
    assert noted(roles, a=first, b=part(300, 1000, shift=-3.0)) == ["b"]
    assert noted(roles, a=part(0, 550), b=part(560, 1000, shift=-5.6)) == []


@pytest.mark.parametrize(("start", "found"), [(1003.0, ["b"]), (1004.0, []), (997.0, [])])
def test_stamps_from_zero_follow_by_their_file_s_start(start: float, found: list[str]) -> None:
    first, second = part(0, 300, epoch=1000.0), part(300, 1000, shift=-3.0, epoch=start)
    assert noted({"a": "fit", "b": "validate"}, a=first, b=second) == found


def test_other_runs_are_no_parts() -> None:
    """Neither a repeated path nor one that stamps put elsewhere."""
    roles = {"a": "fit", "b": "validate"}
    assert noted(roles, a=part(0, 300), b=part(0, 300)) == []
    assert noted(roles, a=part(0, 300), b=part(350, 1000)) == []
    later = part(300, 1000, shift=60.0, epoch=1e9)
    assert noted(roles, a=part(0, 300, epoch=1e9), b=later) == []
    assert noted(roles, a=part(0, 300, epoch=1e9), b=part(300, 1000, epoch=1e9)) == ["b"]


@pytest.mark.parametrize("roles", [*product(["fit", "validate", "contact"], repeat=2)])
def test_a_copy_is_left_out_or_a_stop_sign(roles: tuple[str, str]) -> None:
    """As `spare_copies` has it, for the roles of both."""
    held = dict(zip("ab", roles, strict=True))
    copy, other = (replace(Quality(), fingerprint=list(range(k, k + 40))) for k in (0, 100))
    quality = found_of({"a": copy, "b": copy, "c": other})
    found = name_copies(quality, held | {"c": "fit"})
    same = found[found["code"] == Found.SAME_RUN]
    assert same["recording"].tolist() == ["a", "b"]
    assert {*same["severity"]} == {"warning" if spare_copies(quality, held) else "stop"}

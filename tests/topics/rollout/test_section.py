"""What the report says of simulated arms."""

from dataclasses import asdict, fields, replace

import numpy as np
import pandas as pd

from tests.made_study import study
from tests.topics.pages import section, shown
from ur5lib.report.results import Results
from ur5lib.topics.rollout.errors import rows_of
from ur5lib.topics.rollout.models import IDENTIFIED, STILL
from ur5lib.topics.rollout.rows import RolledOut
from ur5lib.topics.rollout.windows import HORIZONS


def rolled_out(repeats: int = 10) -> Results:
    """A study in which the identified arm is off by some 10 mm a second, less than one that stands
    still, and as much as one with other links.
    """
    random = np.random.default_rng(3)
    own = np.array(HORIZONS)[:, None] * random.uniform(8, 12, (40, len(HORIZONS), 9))
    found = {IDENTIFIED: own, "C": own + 0.1 * random.normal(size=own.shape), STILL: 4 * own}
    columns = ["robot", *(one.name for one in fields(RolledOut))]
    rows = [{"robot": "ur5"} | asdict(row) for row in rows_of(found, own[:repeats], 3)]
    results = study()
    table = pd.DataFrame(rows, columns=columns).replace({None: np.nan})
    return replace(results, tables={**results.tables, "rollout": table})


def test_it_says_how_far_each_is_off_and_where_the_identified_arm_is_not_closer() -> None:
    own = section("rollout", rolled_out())
    assert "Under recorded currents, the simulated flange is 1.7" in own.text
    assert "mm after 2 s from where it went" in own.text
    assert "medians of 40 windows of 2 s on 3 recordings" in own.text
    assert "It is closer than an arm that stands still (in 100 % of the windows)." in own.text
    assert "not proven closer than the links C after 0.1 s" in own.text
    assert "they go nearly the same way" in own.text
    assert "repeats of one motion differ by" in own.text
    assert "repeats" not in section("rollout", rolled_out(repeats=0)).text
    first, *_ = own.tables["rollouts"]
    assert first["model"] == IDENTIFIED
    assert first["after 2 s [mm]"].startswith("35")
    assert "standing still" in own.drawn


def test_the_supplement_has_each_joint() -> None:
    rows = section("rollout", rolled_out(), "details").tables["rollouts-by-joint-ur5"]
    assert [row["after [s]"] for row in rows] == ["0.1"] * 3 + ["0.5"] * 3 + ["2"] * 3
    assert [*rows[0]] == ["after [s]", "model", *(f"joint {k}" for k in range(1, 7))]


def test_without_windows_there_is_no_section() -> None:
    none = rolled_out()
    empty = none.tables["rollout"][:0]
    assert shown("rollout", replace(none, tables={**none.tables, "rollout": empty})) is None

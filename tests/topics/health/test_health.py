"""The health of an arm: from recordings with changed friction to the words of the report."""

import shutil
from collections.abc import Iterator
from dataclasses import fields, replace
from datetime import date, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text

from tests.conftest import Change, Workflow
from tests.current_study import (
    CONSTANT,
    FRICTION,
    OFFSET,
    make_record,
    prior,
    smooth,
)
from tests.made_tables import gathered
from tests.topics.pages import filled, section, shown
from tests.typeset_page import page_of, plain
from ur5lib.channels import TORQUE
from ur5lib.identification.current_regression import fit_currents
from ur5lib.identification.samples import CurrentSamples, columns_of, recorded_path
from ur5lib.records.codes import Found
from ur5lib.records.friction import CurrentFit
from ur5lib.records.prediction import JudgedLoad, Prediction, Scores
from ur5lib.records.quality import Finding, Quality
from ur5lib.records.verdicts import Verdict
from ur5lib.report.figures.house_style import REPORT_FONT_SIZE
from ur5lib.report.results import Results
from ur5lib.robots.friction import BASE_TERMS
from ur5lib.topics.health.condition import QUANTITIES, joint_conditions
from ur5lib.topics.health.examine_joints import checkup, dated
from ur5lib.topics.health.figure import health_figure
from ur5lib.topics.health.judge_health import judge_health
from ur5lib.topics.health.rows import Checkup, Condition, Health, JointChange
from ur5lib.topics.health.track_health import health_of, together

START = date(2026, 3, 3)
QUALITY = Quality(
    frames=1000, findings=[Finding("robot", Found.LOST_FRAMES, "warning", 20, "lost")]
)
NOISE = 0.05  # A
TAKEN = JudgedLoad(2.0, 0.1, (1.8, 2.2), True, 0.0, 2.0, True, np.zeros(3), np.zeros(3))


def worn(seed: int, coulomb: dict[int, float], viscous: dict[int, float]) -> CurrentSamples:
    """A recording whose joints, 1 to 6, have more friction [Nm, Nm s/rad] than the usual one."""
    record, random = make_record(seed), np.random.default_rng(seed)
    current = record.current + NOISE * random.standard_normal(record.current.shape)
    for kind, more in ((BASE_TERMS[0], coulomb), (BASE_TERMS[1], viscous)):
        for joint, size in more.items():
            columns = columns_of(record.joint(joint - 1), [kind])
            current[:, joint - 1] += size * columns[:, -1] / CONSTANT[joint - 1]
    return replace(record, current=current)


@pytest.fixture(scope="module")
def fit() -> CurrentFit:
    return fit_currents([worn(seed, {}, {}) for seed in range(6)], smooth, prior())


def test_friction_of_a_recording_comes_back(fit: CurrentFit) -> None:
    found = joint_conditions(worn(7, {1: 1.0}, {2: 2.0}), smooth, fit)
    true = {(1, "coulomb"): FRICTION[0][0] + 1.0, (2, "viscous"): FRICTION[1][1] + 2.0}
    true |= {(4, "coulomb"): FRICTION[3][0], (5, "viscous"): FRICTION[4][1]}
    true |= {(1, "offset"): OFFSET[0], (2, "torque_constant"): CONSTANT[1], (6, "noise"): NOISE}
    for (joint, name), value in true.items():
        assert found[joint - 1][name][0] == pytest.approx(value, rel=0.1, abs=0.03), (joint, name)
    assert np.isnan(found[5]["torque_constant"]).all()  # nothing loads joint 6


def test_stated_errors_are_those_between_recordings(fit: CurrentFit) -> None:
    """White noise is all that differs between these recordings of one path."""
    bare = make_record(3)
    random = np.random.default_rng(0)
    drawn = [
        joint_conditions(
            replace(bare, current=bare.current + NOISE * random.standard_normal(bare.q.shape)),
            smooth,
            fit,
        )
        for _ in range(40)
    ]
    for joint, name in ((4, "coulomb"), (4, "viscous"), (2, "torque_constant")):
        values = np.array([joints[joint - 1][name] for joints in drawn])
        assert values[:, 1].mean() == pytest.approx(values[:, 0].std(), rel=0.4), name


@pytest.mark.parametrize("bursts", [[1.0], [0.2, 2.0]])
def test_the_error_of_the_noise_is_that_between_recordings(
    fit: CurrentFit, bursts: list[float]
) -> None:
    """At rest; noise that comes in bursts counts as many times as there are bursts."""
    bare, random = make_record(3), np.random.default_rng(0)
    still = replace(bare, q=0 * bare.q, qd=0 * bare.qd)
    values, errors = [], []
    for _ in range(10):
        burst = random.choice(bursts, size=(24, 6)).repeat(len(bare.q) // 24, axis=0)
        noisy = replace(still, current=burst * NOISE * random.standard_normal(bare.q.shape))
        found = np.array([joint["noise"] for joint in joint_conditions(noisy, smooth, fit)])
        values, errors = [*values, *found[:, 0]], [*errors, *found[:, 1]]
    assert np.mean(errors) == pytest.approx(np.std(values), rel=0.3)


def test_a_short_recording_tells_nothing_but_the_noise_of_two_blocks(fit: CurrentFit) -> None:
    two, one = (joint_conditions(make_record(1, seconds), smooth, fit) for seconds in (4.0, 1.5))
    assert np.isnan([[*joint.values()] for joint in one]).all()
    assert np.isfinite([joint["noise"] for joint in two]).all()


@pytest.mark.parametrize(("load", "known"), [(0.2, False), (20.0, True)])  # Nm
def test_a_torque_constant_is_stated_if_it_is_known_to_a_fifth(
    fit: CurrentFit, load: float, known: bool
) -> None:
    record = worn(1, {}, {})
    torque = record.torque + load * np.outer(np.sin(record.q[:, 0]), np.eye(6)[5])
    current = record.current + (torque - record.torque) / CONSTANT
    loaded = replace(record, torque=torque, current=current)
    value, error = joint_conditions(loaded, smooth, fit)[5]["torque_constant"]
    assert (error < 0.2 * value) == known
    assert value == pytest.approx(CONSTANT[5] if known else np.nan, rel=0.1, nan_ok=True)


def test_a_joint_at_rest_has_no_friction_to_tell(fit: CurrentFit) -> None:
    record = worn(1, {}, {})
    still = replace(record, q=0 * record.q, qd=0 * record.qd)
    (first, *_) = joint_conditions(still, smooth, fit)
    assert np.isnan([first[name] for name in QUANTITIES if name != "noise"]).all()


def test_a_recording_has_the_date_that_it_is_given_or_its_stamp_s() -> None:
    stamped, bare = Quality(start_epoch_s=1386687528.2), Quality()
    scored = {"fitted": Scores(*np.zeros((8, 6)))}
    free = Prediction(True, scored)
    assert dated("2026-03-09", stamped, free) == date(2026, 3, 9)
    assert dated("", stamped, free) == date(2013, 12, 10)
    assert dated("", bare, free) is None
    assert dated("2026-03-09", stamped, Prediction(True)) is None  # a stop sign
    assert dated("2026-03-09", stamped, replace(free, load=TAKEN)) is None


def test_recordings_of_a_date_count_by_their_errors_and_their_scatter() -> None:
    alike = together(np.array([1.0, 1.0]), np.array([0.1, 0.1]))
    assert alike == pytest.approx((1.0, 0.1 / np.sqrt(2)))
    apart = together(np.array([0.0, 2.0]), np.array([0.1, 0.1]))
    assert apart == pytest.approx((1.0, 1.0))
    assert together(np.array([1.0, 5.0]), np.array([0.1, 100.0]))[0] == pytest.approx(1.0, abs=0.01)


# From twelve dates to the report


@pytest.fixture(scope="module")
def summary(fit: CurrentFit) -> Health:
    """Joint 2 drifts by a fifth, joint 4 jumps by a quarter on the seventh of twelve dates."""
    return health_of([*_checkups(fit)], PATHS)


PATHS = [recorded_path(worn(20 + k % 3, {}, {})) for k in range(12)]


def _checkups(fit: CurrentFit) -> Iterator[Checkup]:
    for k in range(12):
        viscous = {2: 0.2 * FRICTION[1][1] * k / 11}
        record = worn(20 + k % 3, {4: 0.25 * FRICTION[3][0] * (k >= 6)}, viscous)
        random = np.random.default_rng(k)
        noisy = record.current + NOISE * random.standard_normal(record.current.shape)
        temperature = np.full(record.q.shape, 30.0 + k % 4)
        record = replace(record, current=noisy, temperature=temperature)
        yield checkup(record, smooth, fit, START + timedelta(3 * k), QUALITY)


@pytest.fixture(scope="module")
def results(summary: Health, tmp_path_factory: pytest.TempPathFactory) -> Results:
    return of_arm(summary, tmp_path_factory.mktemp("study"))


def of_arm(summary: Health, folder: Path) -> Results:
    """The two tables of a study of one arm."""
    tables = {
        "health": gathered(Condition, summary.dates, folder),
        "health_changes": gathered(JointChange, summary.changes, folder),
    }
    return Results({}, tables, Path())


def with_verdicts(results: Results) -> Results:
    """The results with the verdicts on them."""
    rows = pd.DataFrame([*map(vars, judged(results))]).replace("", None)
    return replace(results, tables=results.tables | {"verdicts": rows})


def test_what_changed_is_found_and_nothing_else(summary: Health) -> None:
    changes = {(one.joint, one.quantity): one for one in summary.changes}
    assert set(changes) == {(2, "viscous"), (4, "coulomb")}
    grown, jumped = changes[2, "viscous"], changes[4, "coulomb"]
    assert (grown.kind, jumped.kind) == ("drift", "jump")
    assert grown.size / grown.before == pytest.approx(0.2, abs=0.04)
    assert jumped.size / jumped.before == pytest.approx(0.25, abs=0.02)
    assert jumped.first < (START + timedelta(18)).isoformat() <= jumped.last


def test_few_dates_give_no_tables(fit: CurrentFit, tmp_path: Path) -> None:
    summary = health_of([*_checkups(fit)][:5], PATHS[:5])
    assert summary == Health()
    results = of_arm(summary, tmp_path)
    assert judged(results) == []
    assert results.tables["health"].empty
    assert health_figure(*results.tables.values()).data.empty


def test_the_change_is_a_sentence_with_its_dates(results: Results) -> None:
    told = section("health", results)
    jump, slow = (plain(own.text_content()) for own in told.section.iter("li"))
    assert jump.startswith("joint 4: Coulomb friction rose by 2")
    assert jump.endswith("% between 18 and 21 March 2026.")
    assert slow.startswith("joint 2: viscous friction slowly rose by ")
    assert slow.endswith("% from 3 March to 5 April 2026.")
    assert "temperature adds" not in told.text


def test_a_change_makes_the_arm_usable_and_none_makes_it_good(results: Results) -> None:
    first, dates, largest = judged(results)
    assert (first.state, first.reason, first.count, first.of) == ("usable", "changed", 2, 29)
    assert (dates.count, largest.joint) == (12, 4)
    unchanged = results.tables | {"health_changes": results.tables["health_changes"][:0]}
    calm, _ = judged(replace(results, tables=unchanged))
    assert (calm.state, calm.reason, calm.count) == ("good", "", 0)


def judged(results: Results) -> list[Verdict]:
    """The verdicts on the drift of an arm."""
    return judge_health(results.tables["health"], results.tables["health_changes"])


def test_the_section_states_dates_and_lost_frames(results: Results) -> None:
    told = section("health", results)
    assert "ur5 was recorded on 12 dates, from 3 March to 5 April 2026." in told.text
    assert "Temperatures of its joints were recorded." in told.text
    assert "No recording lost more than 2.0 % of its frames." in told.text
    assert [row["when"] for row in told.tables["health-changes"]] == [
        "jump, 18 to 21 March 2026",
        "drift, 3 March to 5 April 2026",
    ]


def test_the_card_has_the_largest_change(results: Results) -> None:
    (card,) = page_of(filled(with_verdicts(results))).find_class("card")
    told = plain(card.text_content())
    assert card.get("data-question") == "drift"
    assert "Largest change, coulomb: +2" in told
    assert told.endswith("joint 4")
    (picture,) = card.iter("svg")
    assert "Coulomb friction of joint 4" in picture.get("aria-label")


def test_every_joint_and_quantity_is_drawn(results: Results) -> None:
    drawing = health_figure(*results.tables.values())
    letters = [text.get_fontsize() for text in drawing.figure.findobj(Text)]
    assert min(letters) >= REPORT_FONT_SIZE
    assert len(drawing.figure.axes) == 36
    assert {*drawing.data["quantity"]} == {*QUANTITIES, "temperature"}
    assert "[A]" in "".join(axis.get_ylabel() for axis in drawing.figure.axes)
    dates, changes = (own.replace("torque_constant", "gain") for own in results.tables.values())
    sensed = health_figure(dates, changes, TORQUE).figure
    assert not any("A]" in axis.get_ylabel() for axis in sensed.axes)


def test_each_joint_is_named(results: Results) -> None:
    """Those of an arm of seven joints, too, above the first row."""
    dates, changes = results.tables.values()
    seventh = dates[dates["joint"] == 6].assign(joint=7)
    axes = health_figure(pd.concat([dates, seventh]), changes).figure.axes
    titles = [axis.get_title("left") for axis in axes[:8]]
    assert titles == [*(f"joint {joint}" for joint in range(1, 8)), ""]


def test_a_jump_is_shaded_darker_than_a_drift(results: Results) -> None:
    dates, changes = results.tables.values()
    darkness = [
        float(patch.get_alpha())
        for kind in ("drift", "jump")
        for axis in health_figure(dates, changes[changes["kind"] == kind]).figure.axes
        for patch in axis.patches
    ]
    assert darkness == sorted({*darkness})
    assert len(darkness) == 2


def test_dates_on_which_no_joint_could_be_judged_draw_nothing(results: Results) -> None:
    dates, changes = results.tables.values()
    assert health_figure(dates[dates["joint"].isna()], changes[:0]).data.empty


def test_dates_of_two_years_are_told_with_both() -> None:
    row = {"robot": "ur5", "joint": 1, "quantity": "viscous", "value": 1.0, "std_error": 0.1}
    rows = [row | {"date": date, "group": 0} for date in ("2025-03-03", "2026-03-09")]
    told = section("health", of_rows(rows, []))
    assert "on 2 dates, from 3 March 2025 to 9 March 2026" in told.text
    assert "Temperatures of its joints were not recorded. No frame was lost." in told.text


def of_rows(dates: list[dict[str, Any]], changes: list[dict[str, Any]]) -> Results:
    """A study with these rows of both tables."""
    rows = {"health": (Condition, dates), "health_changes": (JointChange, changes)}
    tables = {
        name: pd.DataFrame(own, columns=["robot", *(one.name for one in fields(kind))])
        for name, (kind, own) in rows.items()
    }
    return Results({}, tables, Path())


@pytest.mark.parametrize(
    ("groups", "expected"),
    [
        ([0] * 6, "good"),
        ([0, 0, 0, 1, 1, 1], "good"),
        ([0, 1, 2, 3, 4, 5], "not determined"),
        ([0, 0, 1, 1, 2, 3], "not determined"),
    ],
)
def test_drift_is_determined_where_paths_were_repeated(groups: list[int], expected: str) -> None:
    """Otherwise each date has a path of its own, which may explain any change."""
    rows = [
        {"robot": "ur5", "date": f"2020-0{month + 1}-01", "joint": 1, "quantity": "viscous",
         "value": 1.0, "std_error": 0.1, "group": group}
        for month, group in enumerate(groups)
    ]  # fmt: skip
    results = of_rows(rows, [])
    first, *_ = judged(results)
    assert first.state == expected
    assert first.reason == ("" if expected == "good" else "few_dates")
    told = section("health", with_verdicts(results)).text
    assert ("Repeat one motion" in told) is (expected != "good")
    assert ("No joint changed by more than chance explains" in told) is (expected == "good")
    change = {"robot": "ur5", "joint": 1, "quantity": "viscous", "kind": "jump", "size": 0.5}
    change |= {"before": 1.0, "std_error": 0.1, "by_temperature": 0.0}
    change |= {"first": "2020-03-01", "last": "2020-04-01"}
    assert judged(of_rows(rows, [change]))[0].state == "usable"


# In the report, and in the workflow


def test_its_section_is_absent_without_dates(tmp_path: Path) -> None:
    assert shown("health", of_arm(Health(), tmp_path)) is None
    assert shown("health", Results({}, {}, Path())) is None


def test_another_test_of_changes_repeats_no_judge(built_workflow: Workflow, change: Change) -> None:
    change("ur5lib/topics/health/changes.py", "\nEDITED = True\n")
    planned = built_workflow.plan()
    assert planned.keys() >= {"track_health", "draw_health", "make_tables", "write_report"}
    assert planned.keys().isdisjoint({"examine_joints", "judge_recording"})


@pytest.mark.parametrize(("role", "count"), [("contact", 0), ("validate", 1)])
def test_a_contact_tells_nothing_of_the_health(
    built_workflow: Workflow, change: Change, role: str, count: int
) -> None:
    raw = built_workflow.folder / "raw"
    shutil.copytree(raw / "still", raw / "new", dirs_exist_ok=True)
    entry = "  - {name: new, robot: ur5, format: thesis-csv, folder: raw/new, role: %s}\n"
    change("config.yaml", entry % role)
    planned = built_workflow.plan()
    assert [planned.get(step, 0) for step in ("examine_joints", "track_health")] == [count] * 2

"""Recordings that a caller has in memory, and calls that are wrong."""

import os
import pickle
import re
import subprocess
import sys
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

import ur5lib
from tests.conftest import PROJECT
from tests.in_memory import FREE
from ur5lib.errors import InputError, RefusalError, Remark
from ur5lib.force.residual_model import Residuals
from ur5lib.jobs.memory import contents
from ur5lib.records.codes import CauseCode
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.tables import write_table

CHANNELS = ["actual_q", "actual_qd", "actual_current", "target_moment"]
SEEDS = range(4)
OWN = {"t": "timestamp", "q": "actual_q", "i": "actual_current"}


@pytest.fixture(scope="module")
def table(folder: Path) -> pd.DataFrame:
    return pd.read_csv(folder / FREE[0])[:1000]


def columns_of(*channels: str) -> list[str]:
    return [f"{name}_{k}" for name in channels for k in range(6)]


def arrays_of(table: pd.DataFrame) -> dict[str, np.ndarray]:
    """Its clock, positions and currents."""
    q, i = (table[columns_of(OWN[name])].to_numpy() for name in "qi")
    return {"t": table["timestamp"].to_numpy(), "q": q, "i": i}


def assert_same(one: ur5lib.Recordings, other: ur5lib.Recordings) -> None:
    assert one.roles == other.roles
    assert [*one.account["taken_for"]] == [*other.account["taken_for"]]
    for name in one.names:
        found = one[name].device("robot")
        pd.testing.assert_frame_equal(found, other[name].device("robot"), check_exact=True)
        assert found.attrs == other[name].device("robot").attrs
    pd.testing.assert_frame_equal(one.findings(), other.findings())


def spoilt(table: pd.DataFrame, seed: int) -> pd.DataFrame:
    """Some channels in any order, in other units and with other noise; cells and rows missing."""
    draw = np.random.default_rng(seed)
    some = draw.permutation(CHANNELS[1:])[: draw.integers(1, 4)]
    drawn = table[["timestamp", *columns_of("actual_q", *some)]].copy()
    drawn += draw.normal(0, 1e-9, drawn.shape)
    if draw.random() < 0.5:
        drawn[columns_of("actual_q")] = np.rad2deg(drawn[columns_of("actual_q")])
    drawn = drawn.mask(draw.random(drawn.shape) < 1e-4)
    return drawn.drop(index=draw.integers(2, 900, 3)).astype({"actual_q_0": np.float32})


@pytest.mark.parametrize("seed", SEEDS)
def test_a_frame_gives_to_the_last_bit_what_its_file_gives(
    seed: int, table: pd.DataFrame, tmp_path: Path
) -> None:
    frame = spoilt(table, seed)
    frame.to_csv(tmp_path / "recording.csv", index=False)
    assert_same(ur5lib.read(frame, "ur5e"), ur5lib.read(tmp_path / "recording.csv", "ur5e"))


def test_arrays_by_name_give_what_their_archive_gives(table: pd.DataFrame, tmp_path: Path) -> None:
    arrays = arrays_of(table)
    np.savez(tmp_path / "recording.npz", **arrays)
    stated: dict[str, Any] = {"columns": {"actual_q": "q"}, "unit": {"actual_current": "A"}}
    own = ur5lib.read(arrays, "ur5e", **stated)
    assert_same(own, ur5lib.read(tmp_path / "recording.npz", "ur5e", **stated))
    named_file = ur5lib.read({"file": arrays["q"], "t": arrays["t"], "i": arrays["i"]}, "ur5e",
                             columns={"actual_q": "file"})  # fmt: skip
    pd.testing.assert_frame_equal(named_file.q, own.q, check_exact=True)


def test_each_kind_of_table_is_read_alike(table: pd.DataFrame) -> None:
    """Of pandas with the clock as column, index, or levels of names, of Arrow, and nameless."""
    plain = table[["timestamp", *columns_of("actual_q", "actual_qd", "actual_current")]]
    first = ur5lib.read(plain, "ur5e").q
    by_time = plain.drop(columns="timestamp").set_axis(plain["timestamp"].to_numpy())
    levels = plain.set_axis(
        pd.MultiIndex.from_tuples([(name, "") for name in plain.columns]), axis=1
    )
    lists = pd.DataFrame({name: [*values] for name, values in arrays_of(table).items()})
    of_lists = lists.assign(q=[[*row] for row in lists["q"]])  # of NumPy's numbers
    others = [plain.set_index("timestamp"), by_time, levels, pa.table(plain), plain.to_numpy()]
    others += [one.rename(columns=OWN) for one in (lists, of_lists)]
    for other in others:
        pd.testing.assert_frame_equal(ur5lib.read(other, "ur5e").q, first, check_exact=True)
    dated = by_time.set_axis(pd.to_datetime(by_time.index * 1e9 + 1.7e18))
    assert len(ur5lib.read(dated, "ur5e").q) == len(first)


def test_several_have_the_names_that_they_are_given(table: pd.DataFrame, folder: Path) -> None:
    assert ur5lib.read({"a": table, "b/c": table}, "ur5e").names == ["a", "b_c"]
    assert ur5lib.read([table, folder / FREE[1]], "ur5e").names == ["recording_1", "free2"]


@pytest.mark.parametrize("form", ["nameless", "letters", "arrays"])
def test_a_resting_log_takes_its_columns_from_a_moving_one_of_its_form(
    form: str, table: pd.DataFrame
) -> None:
    moving = table[["timestamp", *columns_of("actual_q", "actual_qd", "actual_current")]]
    draw = np.random.default_rng(0)
    resting = moving.iloc[[0] * len(moving)] + draw.normal(0, 1e-5, moving.shape)
    resting["timestamp"] = moving["timestamp"].to_numpy()
    parts = {name: slice(k, k + 6) for name, k in (("u", 1), ("v", 7), ("current", 13))}
    given: list[Any] = [moving.to_numpy(), resting.to_numpy()]
    if form == "letters":
        names = ["t", *(f"{name}{k}" for name in parts for k in range(6))]
        given = [pd.DataFrame(one, columns=names) for one in given]
    elif form == "arrays":
        given = [{"t": one[:, 0]} | {n: one[:, p] for n, p in parts.items()} for one in given]
    with pytest.raises(ur5lib.InputError, match="no positions are found"):
        ur5lib.read(given[1], "ur5e")
    runs = ur5lib.read(given, "ur5e")
    assert runs.line("recording_2").startswith("recording_2: fit, as in recording_1.")
    expected = resting[columns_of("actual_q")].median().to_numpy()
    np.testing.assert_allclose(runs["recording_2"].q.median(), expected, atol=1e-5)


def test_a_line_of_each_recording_is_logged(
    table: pd.DataFrame, caplog: pytest.LogCaptureFixture
) -> None:
    degrees = table[["timestamp", *columns_of("actual_q", "actual_current")]].copy()
    degrees[columns_of("actual_q")] = np.rad2deg(degrees[columns_of("actual_q")])
    runs = ur5lib.read({"one": degrees, "two": table}, "ur5e")
    one, two = caplog.messages
    assert one.startswith("one: fit, time [s], actual_q [deg]")
    assert two.startswith("two: fit, time [s]")
    assert {"recording", "taken_for", "reason"} <= {*runs.account}


SAYS = """
import logging, sys, ur5lib
{before}
ur5lib.read("recording.csv", "ur5e")
"""


@pytest.mark.parametrize(
    ("before", "printed", "logged"),
    [
        ("", True, False),
        ("logging.getLogger('ur5lib').setLevel('WARNING')", False, False),
        ("logging.basicConfig(level='INFO', stream=sys.stderr)", False, True),
    ],
    ids=["as it is", "silenced", "logs are taken"],
)
def test_the_account_is_printed_where_nothing_takes_logs(
    before: str, printed: bool, logged: bool, table: pd.DataFrame, tmp_path: Path
) -> None:
    table.to_csv(tmp_path / "recording.csv", index=False)
    done = subprocess.run(
        [sys.executable, "-c", SAYS.format(before=before)], cwd=tmp_path, text=True,
        env={**os.environ, "PYTHONPATH": str(PROJECT)}, capture_output=True, check=True,
    )  # fmt: skip
    assert (done.stdout.startswith("recording: fit, time [s]")) == printed
    assert ("INFO:ur5lib:recording: fit, time [s]" in done.stderr) == logged


def test_a_recording_is_read_like_one_of_the_same_logger(
    table: pd.DataFrame, tmp_path: Path
) -> None:
    """One at rest, and a short one, which show no joint, unit or order by themselves."""
    nameless = table[["timestamp", *columns_of("actual_q", "actual_qd", "actual_current")]]
    nameless = nameless.set_axis(range(nameless.shape[1]), axis=1)
    moving = ur5lib.read(nameless, "ur5e")
    rest = nameless[:300].copy()
    rest[[*range(1, 19)]] = rest[[*range(1, 19)]].iloc[0].to_numpy()
    rest.to_csv(tmp_path / "rest.csv", index=False, header=False)
    with pytest.raises(ur5lib.InputError, match=r"no positions are found.*, or as `like`, or name"):
        ur5lib.read(tmp_path / "rest.csv", "ur5e")
    still = ur5lib.read(tmp_path / "rest.csv", role="contact", like=moving)
    assert (still.robot, still.roles) == ("ur5e", {"rest": "contact"})
    for own, other in ((still.q, moving.q), (still.current, moving.current)):
        assert [*own] == [*other]
        np.testing.assert_allclose(own.iloc[5], other.iloc[0])
    again = ur5lib.read(nameless[200:320], like=pickle.loads(pickle.dumps(still)))
    np.testing.assert_allclose(again.q.iloc[0], moving.q.iloc[200], atol=1e-6)
    assert not any("/tmp" in text for text in still.account["taken_for"])
    with pytest.raises(ur5lib.InputError, match=r"'free\.csv' is no recording that was read"):
        ur5lib.read(tmp_path / "rest.csv", like="free.csv")


@pytest.mark.filterwarnings("error")
def test_a_joint_that_moves_alone_brings_no_warning(table: pd.DataFrame) -> None:
    columns = columns_of("actual_q", "actual_qd", "actual_current")
    alone = table[["timestamp", *columns]].copy()
    alone[[name for name in columns if not name.endswith("_0")]] = 0.0
    run = ur5lib.read(alone.set_axis(range(alone.shape[1]), axis=1), "ur5e")
    assert run.q["actual_q_0"].nunique() > 100


def test_what_was_stated_of_one_holds_for_those_read_like_it(table: pd.DataFrame) -> None:
    arrays = arrays_of(table)
    stated: dict[str, Any] = {"columns": {"actual_q": "q"}, "unit": {"actual_current": "mA"}}
    known = ur5lib.read(arrays, "ur5e", **stated)
    own = ur5lib.read({name: values[100:] for name, values in arrays.items()}, like=known)
    np.testing.assert_allclose(own.current.iloc[5], known.current.iloc[105], rtol=1e-6)


def test_few_rows_give_no_warning(table: pd.DataFrame) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for count in (0, 1):
            with pytest.raises(ur5lib.InputError, match=r"^recording\.csv"):
                ur5lib.read(table[:count], "ur5e")
        for count in (2, 3, 4):
            assert len(ur5lib.read(table[:count], "ur5e")) == 1


def test_every_public_object_is_the_same_after_it_was_pickled(
    free: ur5lib.Recordings,
    model: ur5lib.Model,
    pushed: ur5lib.Recordings,
    table: pd.DataFrame,
    tmp_path: Path,
) -> None:
    write_table({"time": table["timestamp"].to_numpy()}, tmp_path / "recordings/one/forces.parquet")
    study, in_memory = ur5lib.load(tmp_path), ur5lib.read(table, "ur5e")
    objects = [free, in_memory, model, ur5lib.read_arm("ur5e"), ur5lib.InputError("a fault")]
    for one in objects:
        assert str(pickle.loads(pickle.dumps(one))) == str(one)
    assert pickle.loads(pickle.dumps(study)).recordings == study.recordings == ["one"]
    public = {getattr(ur5lib, name) for name in dir(ur5lib)}
    kinds = {*map(type, [*objects, study]), ur5lib.RecordingWarning}
    assert {one for one in public if isinstance(one, type)} == kinds
    refusal = RefusalError("short", "too short", "sampling")
    assert pickle.loads(pickle.dumps(refusal)).remark == refusal.remark
    again, runs = pickle.loads(pickle.dumps((model, pushed)))
    assert again == model
    assert_same(runs, pushed)
    forces = model.estimate(pushed)
    pd.testing.assert_frame_equal(again.estimate(runs), forces, check_exact=True)
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        (there,) = pool.map(model.estimate, [pushed])
    pd.testing.assert_frame_equal(there, forces, check_exact=True)


NOTHINGS: list[Any] = [None, 3, 2.5, b"x", [], ["x"], "", "a\0b", object(), np.zeros(3), np.nan]
CALLS: dict[str, Callable[[Any, ur5lib.Recordings, ur5lib.Model, Path], object]] = {
    "read": lambda it, *_: ur5lib.read(it),
    "role": lambda it, *_: ur5lib.read("a.csv", None, it),
    "arm": lambda it, *_: ur5lib.read("a.csv", "" if it is None else it),
    "columns": lambda it, *_: ur5lib.read("a.csv", columns=it),
    "unit": lambda it, *_: ur5lib.read("a.csv", unit=it),
    "unit of a channel": lambda it, *_: ur5lib.read("a.csv", unit={"actual_current": it}),
    "rate": lambda it, *_: ur5lib.read("a.csv", rate=it),
    "read_arm": lambda it, *_: ur5lib.read_arm(it),
    "fit": lambda it, *_: ur5lib.fit(it),
    "accept": lambda it, runs, *_: ur5lib.fit(runs, accept=[it]),
    "reason": lambda it, runs, *_: ur5lib.fit(
        runs, accept={"order": "" if isinstance(it, str) else it}
    ),
    "estimate": lambda it, _, fitted, __: fitted.estimate(it),
    "predict": lambda it, _, fitted, __: fitted.predict(it),
    "score": lambda it, _, fitted, __: fitted.score(it),
    "velocity": lambda it, _, fitted, __: fitted.friction([[it]]),
    "load": lambda it, _, fitted, __: fitted.friction(0.1, [it]),
    "table": lambda it, _, fitted, __: fitted.table(it),
    "plot": lambda it, _, fitted, __: fitted.plot(it),
    "joint": lambda it, _, fitted, __: fitted.plot("friction", joint=[it]),
    "save": lambda it, _, fitted, __: fitted.save(it),
    "load_model": lambda it, *_: ur5lib.load_model(it),
    "load a study": lambda it, *_: ur5lib.load(it),
    "of a name": lambda it, runs, *_: runs[it],
    "channel": lambda it, runs, *_: runs.channel(it),
    "device": lambda it, runs, *_: runs.device(it),
    "table of a study": lambda it, _, __, study: ur5lib.load(study).table(it),
    "signals": lambda it, _, __, study: ur5lib.load(study).signals(it),
    "arm of a study": lambda it, _, __, study: ur5lib.load(study).arm(it),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_wrong_call_is_told_in_a_sentence(
    name: str,
    free: ur5lib.Recordings,
    model: ur5lib.Model,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study/recordings").mkdir(parents=True)
    for nothing in NOTHINGS:
        with pytest.raises(ur5lib.InputError) as caught:
            CALLS[name](nothing, free, model, tmp_path / "study")
        assert len(str(caught.value)) < 600


def test_a_stop_sign_is_not_overruled_without_a_reason(free: ur5lib.Recordings) -> None:
    with pytest.raises(ur5lib.InputError, match="accept: order without a reason"):
        ur5lib.fit(free, accept={"order": None})


def test_two_recordings_of_one_name_are_not_taken_for_one(table: pd.DataFrame) -> None:
    one, other = (ur5lib.read(part, "ur5e") for part in (table[:600], table[400:]))
    with pytest.raises(InputError, match="two recordings are named recording; read them"):
        ur5lib.fit([one, other])


def test_what_a_study_or_a_file_lacks_is_told(table: pd.DataFrame) -> None:
    for stated in ({"rate": 125}, {"role": "fit"}):
        with pytest.raises(ur5lib.InputError, match="is a study: write columns"):
            ur5lib.read("mine.yaml", **stated)
    with pytest.raises(ur5lib.InputError, match="`columns` names speed, but it has timestamp"):
        ur5lib.read(table, columns={"actual_qd": "speed"})


def test_why_no_force_is_stated_is_what_the_fit_lacks(model: ur5lib.Model) -> None:
    """And not an effort that was recorded."""
    assert model._why_no_force() == "no current was recorded"
    other = pickle.loads(pickle.dumps(model))
    refused = Residuals(refused=Remark(CauseCode.STILL_JOINTS, "joint 6 is still"))
    other._arm |= contents("residuals", refused)
    assert other._why_no_force() == "joint 6 is still"


@pytest.mark.parametrize("mass", [0.0, 3.0])
def test_a_load_held_throughout_is_warned_of(
    model: ur5lib.Model, tmp_path: Path, mass: float
) -> None:
    """It is no part of the stated force."""
    plan: dict[str, Any] = {
        "trajectory": {"kind": "fourier", "draw": 9, "period_s": 12, "harmonics": 6},
        "undeclared_payload": {"mass": mass, "center_of_mass": [0, 0, 0.06]},
        "seed": 5,
    }
    plan = plan if mass else {**plan, "undeclared_payload": None}
    arm = load_robot(robot_path("ur5e"))
    simulate(arm, SimulatedRecording.model_validate(plan), "rtde-csv", tmp_path, tmp_path / "truth")
    held = ur5lib.read(tmp_path / "robot.csv", "ur5e", role="contact")
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        model.estimate(held)
    told = [str(one.message) for one in given if one.category is ur5lib.RecordingWarning]
    masses = [re.search(r"([\d.]+) kg held throughout, taken off the force", one) for one in told]
    assert [float(own[1]) for own in masses if own] == pytest.approx([mass] * (mass > 0), rel=0.1)

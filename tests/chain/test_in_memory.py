"""The library in a notebook: arms, recordings and models as objects."""

import json
import os
import pydoc
import re
import subprocess
import sys
import time
from ast import literal_eval
from collections import ChainMap
from collections.abc import Mapping, Sequence
from doctest import DocTestParser
from html.parser import HTMLParser
from pathlib import Path
from textwrap import dedent

import numpy as np
import pandas as pd
import pytest
import yaml
from matplotlib.figure import Figure

import ur5lib
from tests.conftest import PROJECT
from tests.in_memory import FREE
from ur5lib.chain.model import FIGURES, TABLES, fit
from ur5lib.chain.shown import Shown, bar
from ur5lib.importing.in_memory import Role
from ur5lib.records.motion import Motion, motions_before
from ur5lib.records.units import BY_TABLE, column_units
from ur5lib.records.verdicts import REASONS
from ur5lib.study.accept import Accept
from ur5lib.tables import write_table
from ur5lib.workspace.topics import modules_of_topics

SCREEN = 26  # lines
ANSWERS = ["predict", "score", "torque", "current", "friction", "single"]  # of a model
ANSWERS += ["estimate", "table", "plot", "export"]
DOOR = {*dir(ur5lib)} - {"__version__"}
EXAMPLES = ["read_arm", "Arm", "read", "Recordings", "fit", "Model", "load_model"]  # in order
EXAMPLES += ["load", "FinishedStudy", "InputError", "run", "nrmse", "RecordingWarning"]
EXAMPLES += [*ur5lib._of_topics()]
HELP, WIDTH = 60, 100  # lines and columns of a terminal as high as a screen
MORE = 12  # lines for each method of a class
SCRIPT = """\
    import ur5lib

    arm: ur5lib.Arm = ur5lib.read_arm("ur5e")
    runs = ur5lib.read(["free1.csv", "free2.csv"], arm)
    print(runs.names, len(runs), runs["free1"].q.attrs["units"])
    model = ur5lib.fit(runs, accept={"constants": "measured on a bench"})
    constants = model.table("torque_constants")
    figure = model.plot("friction")
    model.save("model.json")


    def largest_push(again: ur5lib.Model, file: str) -> float:
        try:
            forces = again.estimate(ur5lib.read(file, arm, role="contact"))
        except ur5lib.InputError as error:
            raise SystemExit(str(error)) from error
        return float(forces["Fmap_Fx"].abs().max())


    print(largest_push(ur5lib.load_model("model.json"), "pushed.csv"))
    study: ur5lib.FinishedStudy = ur5lib.load("results/mine")
    other: ur5lib.Model = study.model("ur5e")
"""


def spoilt(folder: Path, tmp_path: Path, role: Role = "fit") -> ur5lib.Recordings:
    """The recordings whose current of joint 2 has the opposite sign."""
    for name in FREE:
        table = pd.read_csv(folder / name)
        table["actual_current_1"] *= -1
        table.to_csv(tmp_path / name, index=False)
    return ur5lib.read([tmp_path / name for name in FREE], "ur5e", role)


def test_signals_are_frames_with_units(free: ur5lib.Recordings) -> None:
    q = free["free1"].q
    assert [*q] == [f"actual_q_{k}" for k in range(6)]
    assert q.index.name == "time"
    assert q.attrs["units"]["actual_q_0"] == "rad"
    assert free.current.attrs["units"]["actual_current_5"] == "A"
    assert free.current.index.names == ["recording", "time"]
    assert [*free.current.index.unique("recording")] == free.names == ["free1", "free2"]


def test_recordings_are_chosen_by_name_and_by_role(folder: Path) -> None:
    files = [folder / name for name in (*FREE, "pushed.csv")]
    runs = ur5lib.read(files, "ur5e", {"free2": "validate", "pushed": "contact"})
    assert runs.roles == {"free1": "fit", "free2": "validate", "pushed": "contact"}
    assert [one.names for one in runs] == [["free1"], ["free2"], ["pushed"]]
    assert runs["pushed", "free1"].names == runs[["free1", "pushed"]].names == ["free1", "pushed"]
    assert [*map(len, (runs.fit, runs.validate, runs.contact))] == [1, 1, 1]
    assert runs.contact.names == ["pushed"]
    with pytest.raises(ur5lib.InputError, match="none of free1 has the role `contact`"):
        _ = runs.fit.contact
    with pytest.raises(ur5lib.InputError, match="did you mean `free1`"):
        _ = runs["free2", "free11"]
    with pytest.raises(ur5lib.InputError, match="did you mean `pushed`"):
        ur5lib.read(files, "ur5e", {"push": "contact"})
    with pytest.raises(ur5lib.InputError, match="did you mean `contact`"):
        ur5lib.read(files, "ur5e", {"pushed": "contacts"})


def test_a_push_is_told_with_its_band_and_odds(
    model: ur5lib.Model, pushed: ur5lib.Recordings
) -> None:
    forces = model.estimate(pushed)
    during = forces.loc[3.7:4.3]
    assert forces["Fmap_Fx"].loc[3:5].max() == pytest.approx(40, abs=6)
    assert (during["log_odds_Fmap"] > 0).all()
    assert (during["Fmap_std_Fx"] > 0).all()
    before = forces.loc[1:2].filter(like="least_squares")  # which states nothing without a contact
    assert before.isna().all(axis=None)
    assert during.filter(regex="least_squares_(std_)?F").notna().all(axis=None)
    assert forces.attrs["units"]["Fmap_Fx"] == "N"


def test_currents_are_predicted_beside_those_measured(
    model: ur5lib.Model, free: ur5lib.Recordings, pushed: ur5lib.Recordings
) -> None:
    found = model.predict(pushed)
    names = ("predicted_current", "current_band", "actual_current", "residual_current", "tau_ext")
    assert [*found] == [f"{name}_{k}" for name in names for k in range(6)]
    assert {**found.attrs["units"]} == dict(
        zip(["time", *found], ["s", *24 * ["A"], *6 * ["Nm"]], strict=True)
    )
    measured = pushed.current.to_numpy()
    left = measured - found.filter(like="predicted").to_numpy()
    np.testing.assert_array_equal(found.filter(like="residual"), left)
    assert found.loc[3.7:4.3, "tau_ext_1"].abs().min() > 5
    rows = model.score(pushed).query("model == 'fitted'")
    np.testing.assert_allclose(rows["rmse"], np.sqrt(np.mean(left**2, axis=0)), rtol=1e-6)
    assert {*rows["fitted"]} == {"no"}
    own = model.score(free).pivot_table(index="joint", columns="model", values="nrmse")
    assert (own["fitted"] < 0.2).all()
    assert (own["fitted"] < own["least_squares"]).all()


def test_nothing_is_predicted_without_currents(
    model: ur5lib.Model, free: ur5lib.Recordings
) -> None:
    only = free["free1"].device("robot").filter(like="actual_q")
    silent = ur5lib.read({"silent": only}, "ur5e", "validate")
    for answer in (model.predict, model.score):
        with pytest.raises(ur5lib.InputError, match="silent: no current is predicted"):
            answer(silent)


def test_friction_at_a_velocity_is_that_of_the_table(model: ur5lib.Model) -> None:
    rows = model.table("friction")
    totals = rows[rows["parameter"].str.startswith("total_")].set_index(["joint", "parameter"])
    velocities = [0.0, 0.1, 0.5, 1.0]
    found = model.friction(velocities, totals["load"].groupby("joint").first())
    assert found.index.name == "velocity"
    for column, name in (("value", "tau_friction"), ("std_error", "tau_friction_std")):
        by_joint = totals[column].to_numpy().reshape(6, 4).T
        np.testing.assert_allclose(found[[f"{name}_{k}" for k in range(6)]], by_joint, rtol=1e-8)
    assert found.attrs["units"] == {"velocity": "rad/s"} | dict.fromkeys(found, "Nm")
    both = model.friction([-0.5, 0.5], 20)
    # by the last digit alone, which depends on the processor's kernels
    np.testing.assert_allclose(both.iloc[0].abs(), both.iloc[1], rtol=1e-12)
    with pytest.raises(ur5lib.InputError, match=r"load has 2 numbers; give one, or 6"):
        model.friction(0.5, [1, 2])


def test_a_model_is_the_same_after_it_was_saved(
    model: ur5lib.Model, pushed: ur5lib.Recordings, tmp_path: Path
) -> None:
    model.save(tmp_path / "model.json")
    again = ur5lib.load_model(tmp_path / "model.json")
    assert again == model
    pd.testing.assert_frame_equal(again.estimate(pushed), model.estimate(pushed), check_exact=True)
    for name in TABLES:
        pd.testing.assert_frame_equal(again.table(name), model.table(name), check_exact=True)
    with pytest.raises(ur5lib.InputError, match="friction shows recordings"):
        again.plot("friction")
    assert again.plot("knowledge").axes


@pytest.mark.parametrize(
    "place",
    [
        ("arm", "drifts"),
        ("arm", "rotors"),
        ("arm", "summary"),
        ("arm", "residuals"),
        ("arm", "threshold"),
        ("arm", "described"),
        ("fitted", "free1", "payload"),
        ("settings",),
    ],
)
def test_a_damaged_model_is_refused_where_it_is_read(
    model: ur5lib.Model, tmp_path: Path, place: Sequence[str]
) -> None:
    """Not by the first table or force that needs the part, by what reads that."""
    model.save(path := tmp_path / "model.json")
    part = whole = json.loads(path.read_text())
    *way, last = place
    for key in way:
        part = part[key]
    part[last] = ["damaged"]
    path.write_text(json.dumps(whole))
    with pytest.raises(ur5lib.InputError, match=r"holds no model of .*; save it anew"):
        ur5lib.load_model(path)


@pytest.mark.parametrize("name", FIGURES)
def test_figures_are_those_of_the_report(model: ur5lib.Model, name: str) -> None:
    figure = model.plot(name)
    assert isinstance(figure, Figure)
    assert figure.axes


def test_a_joint_s_panel_is_that_of_the_whole_figure(model: ur5lib.Model) -> None:
    (alone,), panels = model.plot("friction", joint=3).axes, model.plot("friction").axes
    assert alone.get_xlabel() == panels[2].get_xlabel()
    for own, one in zip(alone.lines, panels[2].lines, strict=True):
        np.testing.assert_array_equal(own.get_xydata(), one.get_xydata())


def test_each_parameter_may_be_used_or_not(model: ur5lib.Model) -> None:
    table, use = model.table("friction"), model.use
    assert [*use] == ["joint", "parameter", "use", "reason"]
    pd.testing.assert_frame_equal(use, table[[*use]])
    assert {*use["use"]} <= {"yes", "no"}
    assert {*use["reason"].dropna()} <= {*REASONS}
    assert use.loc[use["use"] == "no", "reason"].notna().all()


class Tags(HTMLParser):
    """The rows of a table."""

    rows = 0

    def handle_starttag(self, tag: str, _: object) -> None:
        self.rows += tag == "tr"


def test_each_object_shows_itself_on_one_screen(
    free: ur5lib.Recordings, model: ur5lib.Model
) -> None:
    one, names = free["free1"], [f"run{k}" for k in range(200)]
    entries = [one._study.recordings[0].model_copy(update={"name": name}) for name in names]
    crowd = ur5lib.Recordings(
        one._study.model_copy(update={"recordings": entries}),
        one._arm,
        dict.fromkeys(names, one._files["free1"]),
        dict.fromkeys(names, one._qualities["free1"]),
    )
    shown: list[Shown] = [ur5lib.read_arm("ur5e"), free, model, crowd]
    for each in shown:
        assert len(repr(each).splitlines()) <= SCREEN, type(each)
        html = Tags()
        html.feed(each._repr_html_())
        assert 2 <= html.rows <= SCREEN, type(each)
    assert repr(model.identified).startswith("Robot(ur5e: 6 joints, links ")
    assert repr(free._study) == "Study(notebook: 2 recordings of ur5e)"
    assert max(len(repr(own)) for own in (model.identified, free._study)) < 200


def test_text_from_outside_is_escaped(free: ur5lib.Recordings) -> None:
    class Named(Shown):
        def _title(self) -> str:
            return "<script>\x1b"

        def summary(self) -> pd.DataFrame:
            return pd.DataFrame({"a": ["<b>"]})

    assert "<script>" not in Named()._repr_html_()
    assert "<b>" not in Named()._repr_html_()
    assert "\x1b" not in repr(Named())


def test_what_a_stop_sign_forbids_is_refused_unless_it_is_accepted(
    folder: Path, model: ur5lib.Model, tmp_path: Path
) -> None:
    turned = spoilt(folder, tmp_path)
    title, *table = repr(turned).splitlines()
    assert "stop sign" in title
    assert max(map(len, table)) < 120
    with pytest.raises(ur5lib.InputError, match=r"free1: .*joint 2.*\nfree2: .*accept"):
        ur5lib.fit(turned)
    with pytest.raises(ur5lib.InputError, match=r"free1: .*joint 2"):
        model.estimate(turned)
    reasons = dict.fromkeys(("sign", "unit"), "the motor is turned")
    assert len(model.estimate(turned["free1"], accept=reasons)) > 1000
    with pytest.raises(ur5lib.InputError, match=r"unknown key `sing`.*`sign`"):
        ur5lib.fit(turned, accept={"sing": "a motor is turned"})


def test_no_number_rests_on_an_effort_in_an_unknown_unit(folder: Path, model: ur5lib.Model) -> None:
    """Not the fit, not the model of other recordings, and no reason overrules it."""
    files = [folder / name for name in FREE]
    unknown = ur5lib.read(files, "ur5e", unit={"actual_current": "unknown"})
    assert {*unknown.current.attrs["units"].values()} == {"s", "unit of the file"}
    assert {*unknown.q.attrs["units"].values()} == {"s", "rad"}
    reasons = dict.fromkeys(Accept.model_fields, "it was measured on a bench")
    for refused in (
        lambda: ur5lib.fit(unknown, accept=reasons),
        lambda: model.estimate(unknown, accept=reasons),
        lambda: model.predict(unknown, accept=reasons),
        lambda: model.score(unknown, accept=reasons),
    ):
        with pytest.raises(ur5lib.InputError, match=r"unit of actual_current is unknown.*--unit"):
            refused()


def test_a_fit_knows_the_motion_before_its_recordings(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = dict[str, list[str]]()

    def spied(own: Motion, chain: Sequence[str], motion: Mapping[str, Motion]) -> list[Motion]:
        if chain:
            known[" ".join(chain)] = [*motion]
        return motions_before(own, chain, motion)

    for user in ("fit_friction", "estimate_load", "predict_currents"):
        monkeypatch.setattr(f"ur5lib.steps.{user}.motions_before", spied)
    after = {"free1": None, "free2": "free1", "pushed": "free2"}
    runs = [
        {"name": name, "format": "rtde-csv", "folder": str(folder), "file": f"{name}.csv"}
        | {"role": "fit" if name == "free2" else "contact", "after": earlier}
        for name, earlier in after.items()
    ]
    study = tmp_path / "mine.yaml"
    plain = {"study": "mine", "title": "Mine", "robot": "ur5e", "recordings": runs}
    study.write_text(yaml.safe_dump(plain))
    read = ur5lib.read(study)
    model = ur5lib.fit(read)
    assert known == {"free1": ["free1"]}
    model.estimate(read)
    assert known == {"free1": ["free1"], "free1 free2": ["free1", "free2"]}


def test_without_free_recordings_friction_is_that_of_other_arms(
    pushed: ur5lib.Recordings,
) -> None:
    model = ur5lib.fit(pushed)
    assert "only what other arms have" in repr(model)
    assert model.estimate(pushed)["Fmap_Fx"].abs().max() > 20
    figures = {name: model.plot(name) for name in FIGURES}
    empty = {name for name, figure in figures.items() if not figure.axes}
    assert empty == {"friction", "current_torque", "current_torque_friction", "residuals"}
    assert {figures[name].texts[0].get_text() for name in empty} == {"not recorded"}


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda _, __: ur5lib.read_arm("ur5x"), "no description of `ur5x`.*`ur5"),
        (lambda folder, _: ur5lib.read(folder / "no.csv", "ur5e"), r"no\.csv"),
        (lambda folder, _: ur5lib.read(folder / FREE[0], "ur55"), "ur55"),
        (
            lambda folder, model: model.estimate(ur5lib.read(folder / FREE[0], "ur5")),
            "the model is of ur5e, but free1 of ur5",
        ),
        (lambda _, model: model.table("frictoin"), "did you mean `friction`"),
        (lambda _, model: model.plot("frictoin"), "did you mean `friction`"),
        (lambda _, model: model.plot("friction", joint=7), "joints 1 to 6"),
        (lambda _, model: model.plot("knowledge", joint=1), "no panel of joint 1 in knowledge"),
        (lambda folder, _: ur5lib.load_model(folder / "no.json"), r"no\.json cannot be read"),
        (lambda folder, _: ur5lib.load_model(folder / "wrong.json"), "holds no model"),
        (lambda folder, _: ur5lib.load_model(folder / FREE[0]), "holds no model"),
        (lambda folder, _: ur5lib.load(folder), "holds no results"),
        (lambda folder, _: ur5lib.fit(str(folder / FREE[0])), r"free1\.csv.*ur5lib\.read"),
        (lambda folder, model: model.estimate([folder / FREE[0]]), r"free1\.csv.*ur5lib\.read"),
        (lambda _, __: ur5lib.read([], "ur5e"), "name at least one"),
    ],
)
def test_mistakes_are_told_in_a_sentence(
    call: object, message: str, folder: Path, model: ur5lib.Model
) -> None:
    (folder / "wrong.json").write_text("{}")
    with pytest.raises(ur5lib.InputError, match=message):
        call(folder, model)


def test_a_recording_that_is_not_there_is_answered_with_its_neighbour(
    free: ur5lib.Recordings,
) -> None:
    with pytest.raises(ur5lib.InputError, match="did you mean `free1`"):
        free["free11"]
    with pytest.raises(ur5lib.InputError, match="no actual_torque was recorded"):
        _ = free.torque
    with pytest.raises(ur5lib.InputError, match=r"did you mean `actual_current`.*actual_q, "):
        free.channel("actual_curent")


@pytest.mark.parametrize("terminal", [True, False])
def test_a_bar_is_shown_on_a_terminal_alone(
    terminal: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
    monkeypatch.setenv("TERM", "xterm")
    with bar(2) as advance:
        advance("align_recording free1")
        advance("identify_model")
    shown = capsys.readouterr()
    assert "identify_model" in shown.err if terminal else shown.err == ""
    assert shown.out == ""


def test_tables_have_the_units_of_their_columns(model: ur5lib.Model) -> None:
    units = {name: model.table(name).attrs["units"] for name in TABLES}
    assert units["torque_constants"]["low"] == "Nm/A"
    assert units["cross_validation"] == {"rmse_lowpassed": "A"}
    assert units["rotor_inertia"]["viscous"] == "Nm s/rad"
    assert "value" not in units["friction"]  # each parameter has its own
    assert column_units("current_rmse", ["rmse", "r2"], "Nm") == {"rmse": "Nm"}
    assert column_units("false_alarms", ["per_min", "alarms"], "A") == {"per_min": "1/min"}


def test_every_unit_is_of_a_table_and_a_column_that_there_are() -> None:
    described = pd.read_csv(PROJECT / "docs/data/tables.csv", index_col="table")["columns"]
    of_topics = (topic.UNITS for topic in modules_of_topics("units").values())
    for table, patterns in ChainMap(BY_TABLE, *of_topics).items():
        names = described[table].split(", ")
        for pattern in patterns:
            assert any(re.search(pattern, name) for name in names), (table, pattern)


def test_the_library_is_imported_in_an_instant() -> None:
    program = (
        "import sys, ur5lib; sys.exit(bool(sys.modules.keys() & {'pandas', 'numpy', 'torch'}))"
    )
    began = time.process_time(), os.times().children_user
    done = subprocess.run([sys.executable, "-c", program], cwd=PROJECT, check=False)
    assert done.returncode == 0
    assert os.times().children_user - began[1] < 0.3


def test_every_public_name_is_there_and_documented() -> None:
    """On one screen, with the shapes of its arrays; a name that is no door is not shown."""
    assert {*EXAMPLES} == DOOR
    for name in DOOR:
        own = getattr(ur5lib, name)
        assert 0 < len(own.__doc__.splitlines()) <= SCREEN, name
    with pytest.raises(AttributeError, match="fitt"):
        _ = ur5lib.fitt


def test_the_example_of_every_public_name_runs(
    folder: Path, model: ur5lib.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One after the other, on recordings and results of the names that they have."""
    monkeypatch.chdir(folder)
    forces = pd.DataFrame({"time": [0.0, 0.1], "Fmap_Fx": [1.0, 0.5]})
    write_table(forces, "results/mine/recordings/pushed/forces.parquet", {"Fmap_Fx": "N"})
    Path("mine.yaml").write_text("study: mine\n")  # test_ends_on_disk.py builds one
    monkeypatch.setattr("ur5lib.commands.run.build", lambda *_, **__: None)
    known: dict[str, object] = {"ur5lib": ur5lib}
    of_methods = {f"Model.{name}": getattr(ur5lib.Model, name) for name in ANSWERS}
    documented = {name: getattr(ur5lib, name) for name in EXAMPLES} | of_methods
    for name, own in ({"ur5lib": ur5lib} | documented).items():
        once = name == "ur5lib"  # its fit is that of the next examples
        monkeypatch.setattr(ur5lib, "fit", (lambda _: model) if once else fit, raising=False)
        examples = DocTestParser().get_examples(own.__doc__)
        assert examples, name
        for example in examples:
            if not example.want:
                exec(example.source, known)
            else:
                assert eval(example.source, known) == literal_eval(example.want), name


def shown_by_help(own: object) -> int:
    """Lines of `help`, as a terminal breaks them."""
    text = pydoc.plain(pydoc.render_doc(own))
    return sum(1 + max(0, len(line) - 1) // WIDTH for line in text.splitlines())


def test_help_is_one_screen_and_of_a_class_with_its_methods_a_few() -> None:
    """Errors have the members of every exception; each method alone is one screen, too."""
    assert shown_by_help(ur5lib) <= HELP
    for name in DOOR - {"InputError", "RecordingWarning"}:
        own = getattr(ur5lib, name)
        inside = [of for of in dir(own) if isinstance(own, type) and not of.startswith("_")]
        methods = [one for of in inside if callable(one := getattr(own, of))]
        assert shown_by_help(own) <= HELP + MORE * len(methods), name
        assert all(shown_by_help(one) <= HELP for one in methods), name


@pytest.mark.slow
def test_a_users_script_passes_the_strictest_check(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(dedent(SCRIPT))
    environment = os.environ | {"MYPYPATH": str(PROJECT), "MYPY_CACHE_DIR": str(tmp_path)}
    options = ["--strict", "--follow-imports=silent", "--ignore-missing-imports"]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *options, str(script)],
        cwd=tmp_path, env=environment, text=True, capture_output=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout

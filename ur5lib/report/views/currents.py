"""Friction, torque constants and motor currents: fits, prediction, payload, and the verdicts."""

from collections.abc import Iterator, Set
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.records.friction import MAX_PRIOR_SHARE
from ur5lib.report.page.document import Number, State, Verdict
from ur5lib.report.page.sentences import names, say, spoken
from ur5lib.report.results import AT_REST, Results
from ur5lib.report.views.arms import of_each_arm
from ur5lib.report.views.baseline import (
    MIN_GOOD_BAND_FACTOR,
    MIN_GOOD_COVERAGE,
    WIDE_BAND_COVERAGE,
    AgainstBaseline,
    Rival,
)
from ur5lib.tidy.friction import without_totals
from ur5lib.tidy.models import STOP
from ur5lib.timeseries.arrays import Mask
from ur5lib.timeseries.metrics import NORMAL95

MIN_USABLE_SHARE = 0.5  # of joints, above which constants are usable
WORTHWHILE_BAND_RATIO = 0.9  # of the band of forces, from which on a recording is worth naming
CONSTANTS = ["torque_constant", "gain"]  # the parameter, of currents and of measured torques
CONSTANTS_TOPIC, CURRENTS_TOPIC = "{Constant}s", "Friction and {quantity}s"  # topics
CONSTANT_ESTIMATE = "a constant {quantity}"
UNPROVEN = "unproven fit"  # code of a remark
EXPLAINED = "explained contradiction"  # code of a remark that names the cause
CONTRADICTION_CODES = [
    "unlikely constant",
    "current against constant",
    "torque against gain",
    EXPLAINED,
]
SIGNS = {  # codes of remarks that stop an arm, and what they say of its constants
    "contradicting constants": "contradicted",
    "contradicting gains": "wrong side",
    "unknown side": "unknown side",
}
COMPARED_MODELS = {"fitted": "ours", "least_squares": "rival"}  # the rival has no prior


def predicted(results: Results) -> list[str]:
    """Return the validate recordings whose currents were predicted."""
    fitted = results.rows("current_rmse", model="fitted")["recording"]
    return results.shown(results.with_role("validate", fitted))


def constants(results: Results) -> pd.DataFrame:
    """Return torque constants, offsets and friction by its terms, with the main source of each.

    moved: whether recordings can determine a parameter: offset and friction need motion. Those of
    an arm without fit recordings are typical ones, and count as moved, unless postures were fitted.
    """
    rows = without_totals(results.tables["friction"])
    arms = results.arms()
    moving: dict[str, set[int]] = {}  # on the fit recordings of an arm
    for name in results.with_role("fit") + results.with_role(AT_REST):
        moving.setdefault(arms[name], set()).update(results.moving(name))
    pairs = zip(rows["robot"], rows["joint"], strict=True)
    moved = [robot not in moving or joint in moving[robot] for robot, joint in pairs]
    by_prior = np.where(rows["prior_share"] > MAX_PRIOR_SHARE, "prior", "undetermined")
    return rows.assign(
        moved=np.array(moved, dtype=bool) | rows["parameter"].isin(CONSTANTS),
        source=np.where(rows["determined"] == "yes", "data", by_prior),
    )


def by_joint(results: Results) -> pd.DataFrame:
    """Return constants and friction, with whether the constant of a joint may be used (`use`)."""
    rows = constants(results)
    stopped = rows["robot"].isin(results.rows("remarks", step=STOP)["robot"])
    cases = {
        "stopped": stopped,
        "unlikely": _are_remarked(results, rows, "unlikely constant"),
        "refused": rows["contradicted"].notna(),
        "unproven": _are_remarked(results, rows, UNPROVEN),
        "prior": rows["determined"] != "yes",
        "far": is_far(rows),
    }
    return rows.assign(use=np.select([*cases.values()], [*cases], "yes"))


def _are_remarked(results: Results, rows: pd.DataFrame, code: str) -> Mask:
    """Return which rows are of a joint with a remark of a code."""
    remarked = results.rows("remarks", code=code)[["robot", "joint"]]
    places = pd.MultiIndex.from_frame(rows[["robot", "joint"]])
    return np.asarray(places.isin(pd.MultiIndex.from_frame(remarked)))


def is_far(rows: pd.DataFrame) -> pd.Series:
    """Whether constants are farther from the known ones than on 95 % of arms."""
    return (rows["value"] - rows["known"]).abs() > NORMAL95 * rows["known_std"]


def remarks(results: Results) -> Iterator[str]:
    """Return the remarks of the fit about joints."""
    yield from _by_joints(results.tables["remarks"].dropna(subset="joint"))


def contradictions(results: Results) -> Iterator[str]:
    """Return the remarks on currents and constants that contradict the known ones."""
    rows = results.rows("remarks", code=CONTRADICTION_CODES)
    yield from explained(results)
    yield from _by_joints(rows[rows["code"] != EXPLAINED])


def explained(results: Results) -> Iterator[str]:
    """Return the causes that the checks found of constants that contradict the known ones."""
    for row in results.rows("remarks", code=EXPLAINED).itertuples():
        yield say("currents.explained", row=row)


def _by_joints(rows: pd.DataFrame) -> Iterator[str]:
    for (robot, remark), group in rows.groupby(["robot", "remark"], sort=False):
        yield say("currents.remark", robot=robot, numbers=group["joint"], remark=remark)


def outlooks(results: Results) -> dict[str, tuple[pd.Series, pd.Series]]:
    """Return by arm the bands as they are, and after the recording that narrows forces most."""
    groups = results.rows("next_recordings").groupby("robot", sort=False)
    return {
        str(robot): (
            rows[rows["after"] == "now"].iloc[0],
            rows.sort_values("force", kind="stable").iloc[0],
        )
        for robot, rows in groups
    }


def is_worthwhile(now: pd.Series, best: pd.Series) -> bool:
    """Return whether a recording narrows the band of forces by a tenth or more."""
    return bool(best["force"] <= WORTHWHILE_BAND_RATIO * now["force"])


def farthest_in_time(results: Results) -> Iterator[str]:
    """Say which dated recording of each arm is farthest from all those of the fit."""
    for robot in results.robots():
        away = days_away(results, robot)
        if away and (days := max(away.values())):
            name = max(away, key=away.__getitem__)
            yield say("currents.farthest in time", robot=robot, name=name, days=days)


def days_away(results: Results, robot: str) -> dict[str, int]:
    """Return the days from each dated recording of an arm to the nearest one of its fit."""
    arms, dates, roles = results.arms(), results.dates(), results.roles()
    dated = {name: day for name, day in dates.items() if day and arms[name] == robot}
    fitted = [day for name, day in dated.items() if roles[name] == "fit"]
    return {
        name: min(abs((day - other).days) for other in fitted)
        for name, day in dated.items()
        if fitted and roles[name] in ("validate", "contact")
    }


def unseen(results: Results) -> pd.DataFrame:
    """Return the errors of moving joints on validate recordings without an undeclared load."""
    return in_motion(results, {*results.with_role("validate")} - {*loaded(results)["recording"]})


def in_motion(results: Results, names: Set[str]) -> pd.DataFrame:
    """Return the errors of moving joints on some recordings.

    zero: the error of a constant current, its standard deviation: R² = 1 − RMSE² / zero².
    """
    rows = results.rows("current_rmse", recording=[*names])
    joints = zip(rows["recording"], rows["joint"], strict=True)
    moves = [joint in results.moving(recording) for recording, joint in joints]
    rows = rows[np.array(moves, dtype=bool)]
    return rows.assign(zero=rows["rmse_lowpassed"] / np.sqrt(1 - rows["r2"]))


def prediction(results: Results, recording: str) -> pd.DataFrame:
    """Return the errors on a recording of the models that the report compares."""
    rows = results.rows("current_rmse", recording=recording, model=[*names("model")])
    return rows.assign(zero_rmse_lowpassed=rows["rmse_lowpassed"] / np.sqrt(1 - rows["r2"]))


def loaded(results: Results) -> pd.DataFrame:
    """Return the undeclared loads that are certain by the currents."""
    return results.rows("payload", taken="yes")


def judge_constants(results: Results) -> Verdict | None:
    """Judge by how many constants may be used that the data determine, and by those that forces are
    computed with although they contradict the known ones; None where no friction was fitted.
    """
    rows = results.rows("friction", parameter=CONSTANTS)
    signs = results.rows("remarks", step=STOP)
    if len(signs):
        kind = next((SIGNS[code] for code in signs["code"] if code in SIGNS), "not fitted")
        return Verdict(spoken(CONSTANTS_TOPIC), "do not use", say(f"constants.{kind}"))
    if rows.empty:
        return None
    determined, refused = rows["determined"] == "yes", rows["contradicted"].notna()
    unlikely = [*results.rows("remarks", code="unlikely constant")["joint"].astype(int)]
    against = contradicting(results)
    disputed = rows["joint"].isin(against)
    unproven = _are_remarked(results, rows, UNPROVEN) & ~disputed
    borne_out = ~disputed & ~unproven
    use = determined & borne_out
    usable, apart = rows.loc[use, "joint"], [*rows.loc[is_far(rows) & borne_out, "joint"]]
    state: State = "usable" if use.mean() > MIN_USABLE_SHARE else "not determined"
    if unlikely or (use.all() and not apart):
        state = "do not use" if unlikely else "good"
    words = {"usable": usable, "unlikely": unlikely, "apart": apart, "refused": rows[refused]}
    words["unproven"] = rows.loc[determined & unproven, "joint"]
    words["others"] = rows.loc[~determined & ~disputed, "joint"]
    return Verdict(
        topic=spoken(CONSTANTS_TOPIC),
        state=state,
        sentence=say("constants.verdict", **words, joints=rows["joint"].nunique()),
        **_farthest(rows[determined | refused]) if determined.any() or against else {},
    )


def contradicting(results: Results) -> list[int]:
    """Return the joints whose currents contradict the known constant, whichever is used."""
    rows = results.rows("friction", parameter=CONSTANTS)
    refused = rows.loc[rows["contradicted"].notna(), "joint"]
    unlikely = results.rows("remarks", code="unlikely constant")["joint"]
    return sorted({*refused.astype(int), *unlikely.astype(int)})


def margins(results: Results) -> pd.Series:
    """Return by joint within which share of itself a constant is known at 95 %, the least first:
    of those that the recordings determine and that may be used.
    """
    rows = by_joint(results)
    rows = rows[rows["parameter"].isin(CONSTANTS) & rows["use"].isin(["yes", "far"])]
    off = rows[["low", "high"]].sub(rows["value"], axis="index").abs().max(axis="columns")
    return (off / rows["value"]).groupby(rows["joint"]).max().sort_values()


def _farthest(rows: pd.DataFrame) -> dict[str, Any]:
    """Return evidence and numbers of a verdict: the constant farthest from the known one, of those
    that the currents give, also where they are refused.
    """
    refused = rows["contradicted"].notna()
    ends = ["std_error", "low", "high"]
    rows = rows.assign(value=rows["contradicted"].where(refused, rows["value"]).astype(float))
    rows[ends] = rows[ends].mask(refused).astype(float)
    row = rows.loc[((rows["value"] - rows["known"]).abs() / rows["known_std"]).idxmax()]
    number = Number(
        spoken("determined {constant} farthest from the known one"),
        float(row["value"]),
        spoken("{constant_unit}"),
        f"joint {row['joint']}",
    )
    number = number.within(row["low"], row["high"], "95 %")
    beside = number.beside(row["known"], "the known constant")
    return {"evidence": say("constants.evidence", row=row), "numbers": (beside,)}


def beside_constant(results: Results) -> AgainstBaseline:
    """Return the errors of predicted currents that no fit has seen, beside a constant current's and
    plain least squares'.
    """
    models, unit = unseen(results), spoken("{unit}")
    rows = models.query("model == 'fitted'")
    rival = "plain least squares", models, "rmse_lowpassed"
    return AgainstBaseline(
        *(rows, "rmse_lowpassed", "zero", unit),
        zero=spoken(CONSTANT_ESTIMATE),
        floors=results.floors("current"),
        rival=Rival.beside(*rival, "joint", COMPARED_MODELS),
    )


def decided(results: Results) -> pd.DataFrame:
    """Return the errors by which the predicted currents of each arm are judged, by joint.

    least_squares, i_target: errors of others; held: smallest share of readings within the band;
    torque: the error of a current times the torque constant [Nm].
    """

    def of_arm(own: Results) -> pd.DataFrame:
        against, others = beside_constant(own), ["least_squares", "i_target"]
        means = unseen(own).pivot_table("rmse_lowpassed", "joint", "model").reindex(columns=others)
        held = against.rows.groupby("joint")["coverage95"].min().rename("held")
        rows = against.by_place().join(means).join(held)
        return rows.assign(torque=rows["error"] * torque_constants(own).reindex(rows.index))

    return of_each_arm(results, of_arm)


def torque_constants(results: Results) -> pd.Series:
    """Return the torque constants [Nm/A] of an arm by joint; empty where torques are measured."""
    rows = results.rows("friction", parameter="torque_constant")
    return rows.set_index("joint")["value"].astype(float)


def resting(results: Results) -> list[str]:
    """Return the arms that were fitted at rest alone, in postures."""
    moving = results.arms()
    judged = {moving[name] for name in results.tables["current_rmse"]["recording"]}
    return [robot for robot in results.tables["friction"]["robot"].unique() if robot not in judged]


def judge_currents(results: Results) -> Verdict:
    """Judge the predicted currents by the worst joint, beside a constant current and plain least
    squares, their band by the smallest coverage.
    """
    against = beside_constant(results)
    rows = against.rows
    if against.errors.empty:
        reason = "no motion" if results.with_role("validate") else "no validate"
        reason = "no friction" if results.tables["friction"].empty else reason
        sentence, answers = say(f"currents.{reason}"), tuple(friction_known(results))
        return Verdict(spoken(CURRENTS_TOPIC), "not determined", sentence, answers)
    least = rows.loc[rows["coverage95"].idxmin()]
    coverage, factors = float(least["coverage95"]), rows["band_factor95"]
    place = f"joint {least['joint']} on {least['recording']}"
    share = Number("least share in the 95 % band", 100 * coverage, "%", place)
    cutoff = results.study["settings"]["lowpass"]["currents"]["cutoff_hz"]
    too_wide = (rows.groupby("joint")["band_factor95"].max() < MIN_GOOD_BAND_FACTOR).any()
    words = {"against": against, "factor": factors.max(), "narrowest": factors.min()}
    words |= {"hold": coverage >= MIN_GOOD_COVERAGE, "wide": coverage >= WIDE_BAND_COVERAGE}
    words |= {"least": least}
    return Verdict(
        topic=spoken(CURRENTS_TOPIC),
        state=against.state(coverage, tested=not too_wide),
        sentence=against.after(say("currents.verdict", **words)),
        answers=(*torque_errors(results, against), *friction_known(results)),
        evidence=say("currents.evidence", **words),
        numbers=(*against.numbers(f"RMSE below {cutoff:g} Hz"), share),
    )


def torque_errors(results: Results, against: AgainstBaseline) -> Iterator[str]:
    """Say how large the errors of predicted currents are as torques of the joints."""
    constants = torque_constants(results)
    means = (against.errors["error"] * constants).dropna()
    if len(means):
        rows = against.rows.set_index("joint")[against.error]
        largest = (rows * rows.index.map(constants)).groupby("joint").max()
        yield say("currents.torques", means=means, largest=largest.dropna())


def friction_known(results: Results) -> Iterator[str]:
    """Say how well Coulomb friction is known, and of which joints not even its sign, or only with a
    constant that may not be used.
    """
    rows = by_joint(results).query("parameter == 'coulomb' and moved")
    margins = rows[["low", "high"]].sub(rows["value"], axis="index").abs().max(axis="columns")
    shares = margins / rows["value"].abs()
    told = (rows["source"] == "data") & (shares < 1) & ~rows["use"].isin(["unlikely", "unproven"])
    if len(rows):
        known, open_joints = rows.loc[told, "joint"], rows.loc[~told, "joint"]
        words = {"shares": shares[told], "known": known, "open_joints": open_joints}
        yield say("currents.friction", **words)

"""The report's part on the thesis: its printed numbers and ours."""

from collections.abc import Iterable, Iterator

import numpy as np
import pandas as pd

from ur5lib.force.estimators import LEADING
from ur5lib.report.results import Results
from ur5lib.topics.thesis.found import score, shown_first
from ur5lib.topics.thesis.printed_numbers import EQUAL, UNEXPLAINED

COMPUTED_DIGITS = 4  # of computed numbers
PARAMETER_SYMBOLS = {"torque_constant": "k", "offset": "b"}
CLAIMED_ESTIMATE, CLAIMED_COMPONENT = "F*", "Fz"  # the thesis detects pushes by these
AS_PRINTED = "torque_on_current"  # the direction of regression of Equation 6.5


def torques(results: Results, recording: str) -> pd.DataFrame:
    """Return the torque errors in closed loop, those that cannot be rebuilt first."""
    own = results.rows("torque_mae", recording=recording).drop_duplicates("joint")
    rows = _beside_zero(results, "torque_mae", recording, own.set_index("joint")["zero_mae"])
    if rows["rebuilt"].isna().all():
        return rows[:0]
    return rows.sort_values("rebuilt", key=pd.Series.notna, kind="stable")


def forces(results: Results, recording: str) -> pd.DataFrame:
    """Return the mean errors of the estimates as printed."""
    return _beside_zero(results, "force_mae", recording, _no_force(results, recording)["zero_mae"])


def largest_forces(results: Results, recording: str) -> pd.DataFrame:
    """Return the largest errors of the estimates as printed."""
    return _beside_zero(results, "force_max", recording, _no_force(results, recording)["zero_max"])


def _no_force(results: Results, recording: str) -> pd.DataFrame:
    """Return the errors of a force of zero, by component."""
    rows = results.rows("force_mae", recording=recording, kind="printed", during="all")
    return rows.drop_duplicates("component").set_index("component")


def _beside_zero(
    results: Results, table: str, recording: str, zero: "pd.Series[float]"
) -> pd.DataFrame:
    """Return the printed and rebuilt numbers of a table, with the error of an estimate of zero in
    `zero_rebuilt`; zero: that error, by joint or component.
    """
    rows = results.rows("printed", table=table, recording=recording)
    return rows.assign(zero_rebuilt=rows["number"].astype(str).map(zero.rename(index=str)))


def positions(results: Results, recording: str) -> pd.DataFrame:
    """Return the errors of the joints' positions in closed loop, with printed ones."""
    return _in_loop(results, "q", recording)


def velocities(results: Results, recording: str) -> pd.DataFrame:
    """Return the errors of the joints' velocities in closed loop, with printed ones."""
    return _in_loop(results, "qd", recording)


def _in_loop(results: Results, quantity: str, recording: str) -> pd.DataFrame:
    printed = results.rows("printed", table=f"closed_loop_{quantity}", recording=recording)
    known = printed.assign(joint=printed["number"].astype(int), model=printed["row"])
    rows = results.rows("closed_loop_mae", recording=recording, quantity=quantity)
    return rows.merge(known[["model", "joint", "printed"]], "left", ["model", "joint"])


def loop_drawn(results: Results) -> list[str]:
    """Return the recordings with a drawn closed loop."""
    simulated = results.listed("closed_loop_mae")
    printed = results.shown(shown_first(results, "closed_loop_q"))
    return printed or results.shown([*results.with_role("validate", simulated), *simulated], 1)


def beside_fit(results: Results) -> pd.DataFrame:
    """Return the printed motor constants and friction, with the fitted ones."""
    keys = ["robot", "joint", "parameter"]
    return results.rows("friction").merge(results.rows("printed_friction"), on=keys)


def rebuilt(results: Results, recording: str) -> pd.DataFrame:
    """Return k and b of Equation 6.5: printed, rebuilt, and fitted here with all friction terms."""
    rows = _by_sign(results.rows("published_constants", recording=recording, regression=AS_PRINTED))
    printed = results.rows("printed", table="current_torque", recording=recording)
    known = {(row.row, int(row.number)): row.printed for row in printed.itertuples()}
    rows["printed"] = [known.get(key) for key in zip(rows["sign"], rows["joint"], strict=True)]
    fitted = _fitted(results, recording)[["value", "std_error"]].add_prefix("fitted_")
    return rows.join(fitted, on=["joint", "parameter"])


def _by_sign(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows twice, with `parameter` and `sign`: once with `value` and `std_error` of the
    constant k, once with those of the offset b.
    """
    parts = [
        rows.assign(
            sign=sign, parameter=name, value=rows[name], std_error=rows[f"{name}_std_error"]
        )
        for name, sign in PARAMETER_SYMBOLS.items()
    ]
    return pd.concat(parts)


def _fitted(results: Results, recording: str) -> pd.DataFrame:
    """Return the parameters fitted to the arm of a recording, by joint and parameter."""
    rows = results.rows("friction", robot=results.arms()[recording])
    return rows.set_index(["joint", "parameter"])


def _printed_offsets(results: Results, recording: str) -> "pd.Series[float]":
    """Return the printed offsets [Nm], by joint."""
    rows = results.rows("printed", table="current_torque", row="b", recording=recording)
    return rows.set_index(rows["number"].astype(int))["printed"]


def doubted_joint(results: Results, recording: str) -> int:
    """Return the joint, from 1, with the largest |printed - fitted| offset."""
    fitted = _fitted(results, recording).xs("offset", level="parameter")["value"]
    return int((_printed_offsets(results, recording) - fitted).abs().idxmax())


def on_every_run(results: Results, recording: str) -> pd.DataFrame:
    """Return b and k of the doubted joint by both regressions on every recording in which it
    moves, in the order of its mean torque.
    """
    rows = results.rows("published_constants", joint=doubted_joint(results, recording))
    return _by_sign(rows).sort_values(
        ["mean_torque", "recording", "sign", "regression"], ascending=[True, True, True, False]
    )


def by_source(results: Results) -> pd.DataFrame:
    """Return for each published table how many numbers it has, are rebuilt, are explained by
    errata, and remain unexplained.
    """
    rows = results.tables["printed"]
    equal, left = rows["status"] == EQUAL, rows["status"] == UNEXPLAINED
    counts = {"numbers": 1, "equal": equal, "explained": ~(equal | left), "unexplained": left}
    return rows[["source"]].assign(**counts).groupby("source", sort=False).sum().reset_index()


def left_over(results: Results) -> pd.DataFrame:
    """Return each unexplained number with the nearest computed one, by an erratum or else rebuilt,
    and `off`, its relative deviation.
    """
    rows = results.tables["printed"]
    rows = rows[rows["status"] == UNEXPLAINED]
    nearest = rows["as_erratum_says"].fillna(rows["rebuilt"])
    erratum = rows["erratum"].where(rows["as_erratum_says"].notna())
    return rows.assign(nearest=nearest, off=nearest / rows["printed"] - 1, erratum=erratum)


def with_zero_error(results: Results) -> pd.DataFrame:
    """Return the printed and rebuilt errors of torques and forces, and the error of an estimate of
    zero, on the recordings with printed errors.
    """
    views = {"torque_mae": torques, "force_mae": forces, "force_max": largest_forces}
    return _together(
        view(results, recording)
        for table, view in views.items()
        for recording in shown_first(results, table)
    )


def errors_in_loop(results: Results) -> pd.DataFrame:
    """Return the errors of positions (q) and velocities (qd) in closed loop, with printed ones."""
    views = {"q": positions, "qd": velocities}
    return _together(
        view(results, recording)
        for quantity, view in views.items()
        for recording in shown_first(results, f"closed_loop_{quantity}")
    )


def constants_rebuilt(results: Results) -> pd.DataFrame:
    """Return Equation 6.5 on each recording for which it is printed, as `rebuilt`."""
    return _together(rebuilt(results, name) for name in shown_first(results, "current_torque"))


def offsets_on_runs(results: Results) -> pd.DataFrame:
    """Return b and k of each doubted joint on every recording (`on_every_run`); printed_on: the
    recording with its printed offset.
    """
    return _together(
        on_every_run(results, name).assign(printed_on=name) for name, _ in _doubted(results)
    )


def doubted_offsets(results: Results) -> pd.DataFrame:
    """Return for each doubted joint the printed and the fitted offset, and the least and largest
    offset over recordings by the thesis's regression, with their number.
    """
    every = results.tables["published_constants"]
    every = every[every["regression"] == AS_PRINTED]
    return pd.DataFrame(
        {
            "recording": name,
            "joint": joint,
            "printed": _printed_offsets(results, name)[joint],
            **_fitted(results, name).loc[(joint, "offset"), ["value", "std_error"]],
            **every.loc[every["joint"] == joint, "offset"].agg(["min", "max", "count"]),
        }
        for name, joint in _doubted(results)
    )


def offset_correlations(results: Results) -> pd.DataFrame:
    """Return the correlation of offset and mean torque over the recordings, by joint."""
    rows = results.tables["published_constants"]
    return pd.DataFrame(
        {"joint": joint, "correlation": own["offset"].corr(own["mean_torque"])}
        for joint, own in rows[rows["regression"] == AS_PRINTED].groupby("joint")
    )


def _doubted(results: Results) -> Iterator[tuple[str, int]]:
    """Yield (recording with printed constants, its joint with a doubted offset)."""
    for name in shown_first(results, "current_torque"):
        fitted = results.rows("friction", robot=results.arms()[name], parameter="offset")
        if not {*_printed_offsets(results, name).index}.isdisjoint(fitted["joint"]):
            yield name, doubted_joint(results, name)


def gains_that_differ(results: Results) -> pd.DataFrame:
    """Return the joints with disjoint ranges of a gain on different recordings of an arm."""
    ranges = results.tables["gains"].fillna({"low": 0.0, "high": np.inf})
    ranges = ranges.assign(robot=ranges["recording"].map(results.arms()))
    ends = ranges.groupby(["robot", "gain", "joint"], sort=False).agg({"low": "max", "high": "min"})
    return ends[ends["low"] > ends["high"]].reset_index()[["robot", "gain", "joint"]]


def gains_that_fit(results: Results) -> pd.DataFrame:
    """Return by model the number of joints and recordings on which its printed gains fit as well as
    the best ones.
    """
    rows = results.tables["published_gains"]
    fits = rows[["model"]].assign(fit=rows["fits"] == "yes", of=1)
    return fits.groupby("model", sort=False).sum().reset_index()


def detected(results: Results) -> pd.DataFrame:
    """Return the `ClaimScore` along z of the thesis's estimate and of ours, the number of missed
    pushes, and whether the thesis's claim holds for the estimate.
    """
    scores = {name: score(results, name) for name in (CLAIMED_ESTIMATE, LEADING)}
    known = {name: own for name, own in scores.items() if own is not None}
    rows = pd.DataFrame({"estimate": name} | own._asdict() for name, own in known.items())
    if rows.empty or CLAIMED_ESTIMATE not in known:
        return rows[:0]
    missed = rows["pushes"] - rows["found"]
    holds = np.where((missed == 0) & (rows["above"] == 0), "yes", "no")
    return rows.assign(missed=missed, holds=holds)


def above_threshold(results: Results) -> pd.DataFrame:
    """Return the time above the thesis's threshold along z and the pushes found by it; empty
    without the thesis's estimate.
    """
    rows = results.rows("fixed_threshold", component=CLAIMED_COMPONENT)
    return rows if (rows["estimate"] == CLAIMED_ESTIMATE).any() else rows[:0]


def _together(parts: Iterable[pd.DataFrame]) -> pd.DataFrame:
    """Return the rows of several views as one table, an empty one if there are no views."""
    return pd.concat([pd.DataFrame(), *parts])


def reference(results: Results) -> list[str]:
    """Return the file of published values in a list, [] without one."""
    return [results.study["reference"]] if "reference" in results.study else []

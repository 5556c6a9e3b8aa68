"""docs/benchmark.md: its tables and its sentences, all from the table of scores."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
import pandas as pd

from benchmarks.harness.markdown import markdown, section
from ur5rivals import tuning
from ur5rivals.estimators.ours import OURS
from ur5rivals.study import StudyArm
from ur5rivals.tables import common, interval, number

TEMPLATE = "page.md.jinja"
FIGURES = {  # of the sentences: component and figure, with its name
    ("norm", "rmse"): "error in contact (RMSE)",
    ("Fx", "mae"): "MAE along x",
    ("Fy", "mae"): "MAE along y",
    ("Fz", "mae"): "MAE along z",
    ("norm", "score"): "interval score in contact",
}

OF_OTHER_COMMANDS = (  # titles of sections
    "Torque from motion",
    "Currents from motion alone",
    "Friction beside published values",
    "Loads that change",
)
SIMULATED = "Simulated arms"  # title of the section that `simulated_contacts` measures
ABSENT = "Estimators of the tables above that did not run on all of these seeds:"


class Comparison(NamedTuple):
    """The other estimators compared with ours, in one figure on one recording.

    better: those significantly lower; worse: number of `others` that are significantly higher.
    """

    recording: str
    figure: str
    better: list[str]
    worse: int
    others: int


def page(table: pd.DataFrame, arms: Sequence[StudyArm], further: Mapping[str, Any]) -> str:
    """Return the page in Markdown.

    further: contents of the sections `detections` and `simulated`, None if not measured.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # Markdown
    )
    return environment.get_template(TEMPLATE).render(
        arms=arms,
        rule=rule(),
        opening=[*opening(table)],
        summary=summary(table),
        methods=methods(table),
        **further,
    )


def with_kept(new: str, old: str, measured: bool, estimators: Sequence[str]) -> str:
    """Return the new page with the old page's sections by other commands, and with its section on
    simulated arms unless this was measured.

    estimators: of the tables; those missing in the section are named below it.
    """
    kept = [section(old, title).rstrip() for title in OF_OTHER_COMMANDS if section(old, title)]
    new = "\n\n".join([new.rstrip(), *kept]) + "\n"
    if not measured and section(old, SIMULATED):
        new = new.replace(section(new, SIMULATED), section(old, SIMULATED))
    simulated = section(new, SIMULATED)
    parts = [part for part in simulated.split("\n\n") if not part.startswith(ABSENT)]
    shown = "\n\n".join(parts)
    missing = [own for own in estimators if f"| {own} |" not in simulated]
    if missing and "|" in simulated:
        shown = f"{shown.rstrip()}\n\n{ABSENT} {'; '.join(missing)}."
    return new.replace(simulated, f"{shown.rstrip()}\n\n")


def rule() -> dict[str, str]:
    """Return the numbers of the rule, as the page writes them."""
    return {
        "latency": f"{1000 * tuning.MAX_LATENCY:.0f} ms",
        "reached": f"{tuning.STEP_SHARE:.0%}".replace("%", " %"),
        "push": f"{tuning.PUSH_FORCE:g} N",
    }


def methods(table: pd.DataFrame) -> str:
    """Return the sources and the constants that the rule chose, by arm."""
    first = table.drop_duplicates(["robot", "estimator"]).fillna({"constants": ""})
    chosen = first.pivot_table(
        index=["estimator", "source"], columns="robot", values="constants", aggfunc="first"
    ).fillna("")
    rows = [
        [*names, *values] for names, values in zip(chosen.index, chosen.to_numpy(), strict=True)
    ]
    return markdown(["estimator", "source", *(f"constants, {arm}" for arm in chosen)], rows)


def comparisons(table: pd.DataFrame) -> Iterator[Comparison]:
    """Yield how the others compare with ours, by recording with a sensor and by figure."""
    sensed = table[table["during"] == "contact"]
    for recording, rows in sensed.groupby("recording", sort=False):
        by_component = rows.set_index("component")
        for (component, figure), title in FIGURES.items():
            own = by_component.loc[component].set_index("estimator")
            yield comparison(str(recording), title, own, figure)


def comparison(recording: str, title: str, own: pd.DataFrame, figure: str) -> Comparison:
    """Return the estimators significantly lower than ours, and the number of higher ones.

    Significant: the 95 % interval of the difference excludes zero. Too few contacts give no
    interval.
    """
    others = own.drop(index=OURS).dropna(subset=figure)
    ends = [f"{figure}_more_{end}" for end in ("low", "high")]
    low, high = (others.reindex(columns=ends)[end] for end in ends)
    better = named(others[high < 0], f"{figure}_more")
    return Comparison(recording, title, better, int((low > 0).sum()), len(others))


def named(rows: pd.DataFrame, figure: str) -> list[str]:
    """Return estimators with a figure and its interval, the lowest first."""
    ranked = rows.sort_values(figure).iterrows() if figure in rows else rows.iterrows()
    return [f"{name} by {interval(row, figure)} N" for name, row in ranked]


def findings(table: pd.DataFrame) -> list[str]:
    """Return a sentence for each figure in which another estimator is significantly better."""
    return [
        f"`{own.recording}`, {own.figure}: {', '.join(own.better)}."
        for own in comparisons(table)
        if own.better
    ]


def opening(table: pd.DataFrame) -> Iterator[str]:
    """Yield the first sentences of the page: the number of estimators, and the best ones."""
    vector = table[(table["component"] == "norm") & (table["during"] == "contact")]
    kinds = table.drop_duplicates("estimator")["causal"].value_counts()
    yield (
        f"{kinds.sum()} estimators, {kinds.get('yes', 0)} of them causal, on "
        f"{table['recording'].nunique()} recordings of {table['robot'].nunique()} arms; "
        f"{vector['recording'].nunique()} have a force sensor."
    )
    for recording, rows in vector.groupby("recording", sort=False):
        by_name = rows.set_index("estimator")
        causal = rows[(rows["causal"] == "yes") & (rows["latency_s"] > 0)].sort_values("rmse")
        best = "".join(
            f"; of the causal ones, {row['estimator']} is best, {interval(row, 'rmse')} N at "
            f"{1000 * row['latency_s']:.0f} ms"
            for _, row in causal.head(1).iterrows()
        )
        none = (
            f" (no force: {number(by_name.loc['zero', 'rmse'])} N)"
            if "zero" in by_name.index
            else ""
        )
        yield f"`{recording}`: {OURS} errs by {interval(by_name.loc[OURS], 'rmse')} N{none}{best}."
    all_of_them = [*comparisons(table)]
    yield (
        f"Of {sum(own.others for own in all_of_them)} comparisons with {OURS} (RMSE, errors along "
        "each axis, interval score), another estimator is better beyond chance in "
        f"{sum(len(own.better) for own in all_of_them)} and worse in "
        f"{sum(own.worse for own in all_of_them)}."
    )
    yield from (f"Better than {OURS} beyond chance: {one}" for one in findings(table))
    free = false_force(table)
    if OURS in free.index and "momentum observer" in free.index:
        yield (
            f"Where nothing touches the arm, {OURS} states {number(free[OURS])} N, the momentum "
            f"observer {number(free['momentum observer'])} N."
        )


def false_force(table: pd.DataFrame) -> pd.Series:
    """Return the median of |F| [N] without contact, by estimator, mean over recordings."""
    if "median" not in table:
        return pd.Series(dtype=float)
    return table.dropna(subset="median").groupby("estimator")["median"].mean()


def summary(table: pd.DataFrame) -> str:
    """Return a row for each estimator, sorted by its mean error over recordings with a force
    sensor; those that lack a recording are last.
    """
    vector = table[(table["component"] == "norm") & (table["during"] == "contact")]
    recordings, free = [*vector["recording"].unique()], false_force(table)
    errors = vector.groupby("estimator")["rmse"].agg(["size", "mean"])
    order = errors.sort_values(["size", "mean"], ascending=[False, True], kind="stable").index
    rows = []
    for name in [*order, *free.index.difference(order)]:
        own = vector[vector["estimator"] == name].set_index("recording")
        cells = [interval(own.loc[one], "rmse") if one in own.index else "" for one in recordings]
        inside = own["coverage95"].dropna() if "coverage95" in own else own["rmse"][:0]
        band = f"{inside.min():.2f} to {inside.max():.2f}" if len(inside) else ""
        about = table[table["estimator"] == name].iloc[0]
        rows.append([*common(about), *cells, band, number(free.get(name))])
    names = [str(one).removeprefix("Movement_").replace("_", " ") for one in recordings]
    columns = ["estimator", "causal", "latency", *names, "in band", "free [N]"]
    return markdown(columns, rows)

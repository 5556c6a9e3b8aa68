"""docs/benchmark.md: its tables and its sentences, all from the table of scores."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
import pandas as pd

from benchmarks.harness.markdown import markdown, section
from ur5lib.force import contact_figures, detection
from ur5rivals import tuning
from ur5rivals.estimators.ours import OURS
from ur5rivals.study import StudyArm
from ur5rivals.tables import interval, tables

TEMPLATE = "page.md.jinja"
COMPARED = ["recording", "figure", f"{OURS} [N]", "better beyond chance", "lower within chance",
            "worse beyond chance"]  # fmt: skip
FIGURES = {  # what the sentences are about: component and figure, and how it is called
    ("norm", "rmse"): "error in contact (RMSE)",
    ("Fx", "mae"): "MAE along x",
    ("Fy", "mae"): "MAE along y",
    ("Fz", "mae"): "MAE along z",
    ("norm", "score"): "interval score in contact",
}

OF_OTHER_COMMANDS = "Torque from motion", "Friction beside published values"  # titles of sections
SIMULATED = "Simulated arms"  # title of the section that `simulated_contacts` measures
ABSENT = "Estimators of the tables above that did not run on all of these seeds:"


class Comparison(NamedTuple):
    """The other estimators beside ours, in one figure on one recording.

    better: lower beyond chance; lower: within chance; worse: how many of the `others` are higher
    beyond chance.
    """

    recording: str
    figure: str
    ours: str
    better: list[str]
    lower: list[str]
    worse: int
    others: int


def page(table: pd.DataFrame, arms: Sequence[StudyArm], further: Mapping[str, Any]) -> str:
    """Return the page in Markdown.

    further: `detections` and `simulated`, what these sections hold, None where it was not measured.
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
        findings=findings(table),
        causal=causal_findings(table),
        compared=compared_table(table),
        tables=tables(table),
        methods=methods(table),
        **further,
    )


def with_kept(new: str, old: str, measured: bool, estimators: Sequence[str]) -> str:
    """Return the new page with the old page's sections of other commands, and with that on
    simulated arms unless it was measured.

    estimators: of the tables. Those that the section does not show are named below it.
    """
    kept = [section(old, title).rstrip() for title in OF_OTHER_COMMANDS if section(old, title)]
    new = "\n\n".join([new.rstrip(), *kept]) + "\n"
    if not measured and section(old, SIMULATED):
        new = new.replace(section(new, SIMULATED), section(old, SIMULATED))
    simulated = section(new, SIMULATED)
    shown = "\n".join(line for line in simulated.splitlines() if not line.startswith(ABSENT))
    missing = [own for own in estimators if f"| {own} |" not in simulated]
    if missing and "|" in simulated:
        shown = f"{shown.rstrip()}\n\n{ABSENT} {'; '.join(missing)}."
    return new.replace(simulated, f"{shown.rstrip()}\n\n")


def rule() -> dict[str, str]:
    """Return the numbers of the rule and of the scores, as the page writes them."""
    return {
        "latency": f"{1000 * tuning.MAX_LATENCY:.0f} ms",
        "reached": f"{tuning.STEP_SHARE:.0%}".replace("%", " %"),
        "push": f"{tuning.PUSH_FORCE:g} N",
        "contact": f"{detection.CONTACT_FORCE:g} N",
        "free": f"{detection.FREE_FORCE:g} N",
        "apart": f"{detection.CONTACT_CLEARANCE:g} s",
        "touch": f"{detection.TOUCH_FORCE:g} N",
        "draws": f"{contact_figures.CONTACT_RESAMPLES}",
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
    """Return who is lower than ours, beyond chance or within it, and who is higher beyond chance.

    Beyond chance is a difference whose 95 % interval does not contain zero; too few contacts give
    no interval.
    """
    others = own.drop(index=OURS).dropna(subset=figure)
    ends = [f"{figure}_more", f"{figure}_more_low", f"{figure}_more_high"]
    more, low, high = (others.reindex(columns=ends)[end] for end in ends)
    more = more.fillna(others[figure] - own.loc[OURS, figure])
    return Comparison(
        recording=recording,
        figure=title,
        ours=interval(own.loc[OURS], figure),
        better=named(others[high < 0], ends[0]),
        lower=named(others[(more < 0) & ~(high < 0)], ends[0]),
        worse=int((low > 0).sum()),
        others=len(others),
    )


def named(rows: pd.DataFrame, figure: str) -> list[str]:
    """Return estimators with a figure and its interval, the lowest first."""
    ranked = rows.sort_values(figure).iterrows() if figure in rows else rows.iterrows()
    return [f"{name} by {interval(row, figure)} N" for name, row in ranked]


def findings(table: pd.DataFrame) -> list[str]:
    """Return a sentence for each figure in which another estimator is better beyond chance."""
    return [
        f"On `{own.recording}`, {own.figure}: {', '.join(own.better)}."
        for own in comparisons(table)
        if own.better
    ]


def causal_findings(table: pd.DataFrame) -> list[str]:
    """Return a sentence for each recording with a sensor: the best of the causal estimators."""
    vector = table[(table["component"] == "norm") & (table["during"] == "contact")]
    known = vector[(vector["causal"] == "yes") & (vector["latency_s"] > 0)]
    best = known.sort_values("rmse").groupby("recording", sort=False).head(1)
    return [
        f"On `{row['recording']}`: {row['estimator']}, {interval(row, 'rmse')} N at a latency of "
        f"{1000 * row['latency_s']:.0f} ms; {interval(row, 'rmse_more', sign='+')} N against F̂ᵐᵃᵖ."
        for _, row in best.sort_index().iterrows()
    ]


def compared_table(table: pd.DataFrame) -> str:
    """Return all comparisons with ours; of those lower within chance, the lowest is named."""
    rows = []
    for own in comparisons(table):
        lower = f"{len(own.lower)}: {own.lower[0]}" if own.lower else "none"
        better, worse = ", ".join(own.better) or "none", f"{own.worse} of {own.others}"
        rows.append([own.recording, own.figure, own.ours, better, lower, worse])
    return markdown(COMPARED, rows)

"""docs/benchmark.md: its tables and its sentences, all from the table of scores."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
import pandas as pd

from benchmarks.estimators.ours import OURS
from benchmarks.harness import tuning
from benchmarks.harness.study import Arm
from ur5lib.force import contact_figures, contact_link, detection

TEMPLATE = "page.md.jinja"
SENSED = ["estimator", "causal", "latency", "RMSE [N]", "RMSE less ours [N]", "MAE x, y, z [N]",
          "slope x, y, z", "in band in contact", "interval score in contact [N]",
          "free MAE x, y, z [N]"]  # fmt: skip
FREE = ["estimator", "causal", "latency", "median [N]", "95 % below [N]", "zero in band"]
COMPARED = ["recording", "figure", f"{OURS} [N]", "better beyond chance", "lower within chance",
            "worse beyond chance"]  # fmt: skip
FIGURES = {  # what the sentences are about: component and figure, and how it is called
    ("norm", "rmse"): "error in contact (RMSE)",
    ("Fx", "mae"): "MAE along x",
    ("Fy", "mae"): "MAE along y",
    ("Fz", "mae"): "MAE along z",
    ("norm", "score"): "interval score in contact",
}


MEASURED = {  # sections by the name of what other benchmarks measure
    "simulated": "Simulated arms",
    "links": "Which link was touched",
    "currents": "Currents along paths that no fit has seen",
    "curve": "Currents by few recordings",
    "curve_forces": "Forces by few recordings",
    "days": "Days left out",
    "drawn": "Arms drawn from the population",
}
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


def page(table: pd.DataFrame, arms: Sequence[Arm], further: Mapping[str, Any]) -> str:
    """Return the page in Markdown.

    further: what the sections that other benchmarks measure hold, None where they did not run.
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


def with_kept(new: str, old: str, further: Mapping[str, Any], estimators: Sequence[str]) -> str:
    """Return the new page with the old page's text of each section that was not measured again.

    further: as in `page`; estimators: of the tables. Those that the section on simulated arms does
    not show are named below it.
    """
    for name, title in MEASURED.items():
        if further.get(name) is None and section(old, title):
            new = new.replace(section(new, title), section(old, title))
    simulated = section(new, MEASURED["simulated"])
    shown = "\n".join(line for line in simulated.splitlines() if not line.startswith(ABSENT))
    missing = [own for own in estimators if f"| {own} |" not in simulated]
    if missing and "|" in simulated:
        shown = f"{shown.rstrip()}\n\n{ABSENT} {'; '.join(missing)}."
    return new.replace(simulated, f"{shown.rstrip()}\n\n")


def section(text: str, title: str) -> str:
    """Return a section of a page with its heading, up to the next one; empty if there is none."""
    found = re.search(rf"^## {re.escape(title)}\n.*?(?=^## |\Z)", text, re.DOTALL | re.MULTILINE)
    return found.group() if found else ""


def rule() -> dict[str, str]:
    """Return the numbers of the rule and of the scores, as the page writes them."""
    return {
        "latency": f"{1000 * tuning.MOST:.0f} ms",
        "reached": f"{tuning.REACHED:.0%}".replace("%", " %"),
        "push": f"{tuning.PUSH:g} N",
        "contact": f"{detection.CONTACT:g} N",
        "free": f"{detection.FREE:g} N",
        "apart": f"{detection.CLEAR:g} s",
        "touch": f"{detection.TOUCH:g} N",
        "draws": f"{contact_figures.DRAWS}",
        "sure": f"{contact_link.SURE:.0%}".replace("%", " %"),
    }


def tables(table: pd.DataFrame) -> str:
    """Return a heading and a table for each recording, the smallest error first."""
    parts = []
    for recording, own in table.groupby("recording", sort=False):
        sensed = "rmse" in own and own["rmse"].notna().any()
        shown = sensed_table(own) if sensed else free_table(own)
        title = f"{recording}, {own['robot'].iloc[0]}"
        if sensed:
            title += f", {own['contacts'].max():.0f} contacts"
        parts.append(f"### {title}\n\n{shown}\n")
    return "\n".join(parts)


def sensed_table(own: pd.DataFrame) -> str:
    """Return the table of a recording with a force sensor."""
    vector = own[(own["component"] == "norm") & (own["during"] == "contact")]
    rows = []
    for _, row in vector.sort_values("rmse", kind="stable").iterrows():
        axes = own[(own["estimator"] == row["estimator"]) & (own["component"] != "norm")]
        contact, free = (axes[axes["during"] == during] for during in ("contact", "free"))
        difference = "" if row["estimator"] == OURS else interval(row, "rmse_more", sign="+")
        cells = [*common(row), interval(row, "rmse"), difference]
        cells += [numbers(contact["mae"]), numbers(contact["slope"], 2), share(row["coverage95"])]
        rows.append([*cells, interval(row, "score"), numbers(free["mae"])])
    return markdown(SENSED, rows)


def free_table(own: pd.DataFrame) -> str:
    """Return the table of a recording that nothing touches."""
    rows = [
        [*common(row), number(row["median"]), number(row["largest95"]), share(row["coverage95"])]
        for _, row in own.sort_values("largest95", kind="stable").iterrows()
    ]
    return markdown(FREE, rows)


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


def common(row: pd.Series) -> list[str]:
    """Return the cells that both tables begin with."""
    latency = row["latency_s"]
    known = "" if pd.isna(latency) else f"{1000 * latency:.0f} ms"
    return [row["estimator"], row["causal"], known]


def interval(row: pd.Series, figure: str, sign: str = "") -> str:
    """Return a figure with its 95 % interval, where it has one."""
    value = number(row.get(figure), sign=sign)
    low, high = (row.get(f"{figure}_{end}") for end in ("low", "high"))
    return value if low is None or pd.isna(low) else f"{value} ({number(low)} to {number(high)})"


def number(value: float | None, digits: int = 1, sign: str = "") -> str:
    """Return a number, empty where there is none."""
    return "" if value is None or pd.isna(value) else f"{value:{sign}.{digits}f}".replace("-", "−")


def numbers(values: Iterable[float], digits: int = 1) -> str:
    """Return some numbers in one cell."""
    return ", ".join(number(value, digits) for value in values)


def share(value: float) -> str:
    """Return a share in percent, empty where there is none."""
    return "" if pd.isna(value) else f"{value:.0%}"


def markdown(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)

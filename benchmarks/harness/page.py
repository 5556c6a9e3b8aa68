"""docs/benchmark.md: its tables and its sentences, all from the table of scores."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import jinja2
import pandas as pd

from benchmarks.estimators.ours import OURS
from benchmarks.harness.study import Arm

TEMPLATE = "page.md.jinja"
SENSED = ["estimator", "causal", "latency", "RMSE [N]", "against ours [N]", "MAE x, y, z [N]",
          "slope x, y, z", "in band", "interval score [N]", "free MAE x, y, z [N]"]  # fmt: skip
FREE = ["estimator", "causal", "latency", "median [N]", "95 % below [N]", "zero in band"]
FIGURES = {  # what the sentences are about: component and figure, and how it is called
    ("norm", "rmse"): "error in contact (RMSE)",
    ("Fx", "mae"): "MAE along x",
    ("Fy", "mae"): "MAE along y",
    ("Fz", "mae"): "MAE along z",
    ("norm", "score"): "interval score",
}


def page(table: pd.DataFrame, arms: Sequence[Arm]) -> str:
    """Return the page in Markdown."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # Markdown
    )
    return environment.get_template(TEMPLATE).render(
        tables=tables(table), findings=findings(table), arms=arms, methods=methods(table)
    )


def tables(table: pd.DataFrame) -> str:
    """Return a heading and a table for each recording, the smallest error first."""
    parts = []
    for recording, own in table.groupby("recording", sort=False):
        sensed = "rmse" in own and own["rmse"].notna().any()
        shown = sensed_table(own) if sensed else free_table(own)
        parts.append(f"### {recording}, {own['robot'].iloc[0]}\n\n{shown}\n")
    return "\n".join(parts)


def sensed_table(own: pd.DataFrame) -> str:
    """Return the table of a recording with a force sensor."""
    vector = own[(own["component"] == "norm") & (own["during"] == "contact")]
    rows = []
    for _, row in vector.sort_values("rmse").iterrows():
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
        for _, row in own.sort_values("largest95").iterrows()
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


def findings(table: pd.DataFrame) -> list[str]:
    """Return who beats ours and who does not, by recording with a sensor and by figure."""
    if "rmse" not in table:
        return []
    sensed = table[table["during"] == "contact"]
    return [
        finding(f"`{recording}`, {title}", own.loc[component].set_index("estimator"), figure)
        for recording, rows in sensed.groupby("recording", sort=False)
        for own in [rows.set_index("component")]
        for (component, figure), title in FIGURES.items()
    ]


def finding(title: str, own: pd.DataFrame, figure: str) -> str:
    """Return who is better than ours on a recording, beyond chance or within it, with numbers."""
    place = f"- {title}: {OURS} has {interval(own.loc[OURS], figure)} N. "
    rivals = own.drop(index=OURS)
    rivals = rivals[rivals[figure].notna()]
    if f"{figure}_more" not in own or rivals[f"{figure}_more"].isna().all():
        lower = rivals[rivals[figure] < own.loc[OURS, figure]]
        return place + listed("Lower, on too few contacts for an interval", lower, figure)
    better = rivals[rivals[f"{figure}_more_high"] < 0]
    worse = rivals[rivals[f"{figure}_more_low"] > 0]
    lower = rivals[(rivals[f"{figure}_more"] < 0)].drop(index=better.index)
    clear = listed("Better beyond chance", better, f"{figure}_more")
    within = listed("Lower, but within chance", lower, f"{figure}_more")
    return f"{place}{clear} {within} Worse beyond chance: {len(worse)} of {len(rivals)}."


def listed(title: str, rows: pd.DataFrame, figure: str) -> str:
    """Return a sentence that lists estimators with a figure."""
    named = [
        f"{name} ({interval(row, figure)} N)" for name, row in rows.sort_values(figure).iterrows()
    ]
    return f"{title}: {', '.join(named) or 'none'}."


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

"""The leaderboard's tables in Markdown, by recording."""

from collections.abc import Iterable, Sequence

import pandas as pd

from ur5rivals.estimators.ours import OURS

SENSED_COLUMNS = [
    *("estimator", "causal", "latency", "RMSE [N]", "RMSE less ours [N]", "MAE x, y, z [N]"),
    *("slope x, y, z", "in band in contact", "width of the band in contact [N]"),
    *("interval score in contact [N]", "of the whole run [N]", "free MAE x, y, z [N]"),
]
FREE_COLUMNS = ["estimator", "causal", "latency", "median [N]", "95 % below [N]", "zero in band"]


def tables(table: pd.DataFrame) -> str:
    """Return a heading and a table for each recording, the smallest error first."""
    parts = []
    for recording, rows in table.groupby("recording", sort=False):
        sensed = "rmse" in rows and rows["rmse"].notna().any()
        text = sensed_table(rows) if sensed else free_table(rows)
        title = f"{recording}, {rows['robot'].iloc[0]}"
        if sensed:
            title += f", {rows['contacts'].max():.0f} contacts"
        parts.append(f"### {title}\n\n{text}\n")
    return "\n".join(parts)


def sensed_table(scores: pd.DataFrame) -> str:
    """Return the table of a recording with a force sensor."""
    vector = scores[(scores["component"] == "norm") & (scores["during"] == "contact")]
    rows = []
    for _, row in vector.sort_values("rmse", kind="stable").iterrows():
        axes = scores[(scores["estimator"] == row["estimator"]) & (scores["component"] != "norm")]
        contact, free = (axes[axes["during"] == during] for during in ("contact", "free"))
        difference = "" if row["estimator"] == OURS else interval(row, "rmse_more", sign="+")
        cells = [*common(row), interval(row, "rmse"), difference]
        cells += [numbers(contact["mae"]), numbers(contact["slope"], 2), share(row["coverage95"])]
        cells += [number(row.get("width")), interval(row, "score"), number(row.get("score_whole"))]
        rows.append([*cells, numbers(free["mae"])])
    return markdown(SENSED_COLUMNS, rows)


def free_table(scores: pd.DataFrame) -> str:
    """Return the table of a recording that nothing touches."""
    rows = [
        [*common(row), number(row["median"]), number(row["largest95"]), share(row["coverage95"])]
        for _, row in scores.sort_values("largest95", kind="stable").iterrows()
    ]
    return markdown(FREE_COLUMNS, rows)


def common(row: pd.Series) -> list[str]:
    """Return the cells that both tables begin with."""
    latency = row["latency_s"]
    shown_latency = "" if pd.isna(latency) else f"{1000 * latency:.0f} ms"
    return [row["estimator"], row["causal"], shown_latency]


def interval(row: pd.Series, figure: str, sign: str = "") -> str:
    """Return a figure with its 95 % interval, if it has one."""
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

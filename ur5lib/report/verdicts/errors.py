"""Errors by joint or component beside those of zero, averaged over recordings."""

import pandas as pd

from ur5lib.report.cells import SMALLEST_DIFFERENCE, rounded
from ur5lib.report.document import Number

ZERO = "an estimate of zero"


def by_joint(rows: pd.DataFrame, error: str, zero: str, name: str = "joint") -> pd.DataFrame:
    """Return error, zero, and the range of errors over recordings (low, high, count), by `name`.

    What hardly has an error of zero is left out: nothing acts there.
    """
    groups = rows.groupby(name, sort=False)
    table = groups[error].agg(error="mean", low="min", high="max", count="size")
    table["zero"] = groups[zero].mean()
    return table[table["zero"] > SMALLEST_DIFFERENCE]


def ratios(errors: pd.DataFrame) -> dict[str, float]:
    """Return the errors as shares of those of zero, by name."""
    return {str(name): float(row.error / row.zero) for name, row in errors.iterrows()}


def worst(errors: pd.DataFrame) -> object:
    """Return the name whose error is the largest share of that of zero."""
    return (errors["error"] / errors["zero"]).idxmax()


def stated(row: pd.Series, name: str, unit: str, place: str, zero: str = ZERO) -> Number:
    """Return an error with its range over recordings and its baseline."""
    several = row["count"] > 1
    return Number(
        name=name,
        value=float(row["error"]),
        unit=unit,
        place=place,
        low=float(row["low"]) if several else None,
        high=float(row["high"]) if several else None,
        interval=f"range over {row['count']:.0f} recordings" if several else "",
        baseline=float(row["zero"]),
        baseline_of=zero,
    )


def with_range(row: pd.Series, digits: int, unit: str, zero: str = ZERO) -> str:
    """Return an error, its range over recordings, and its baseline."""
    low, high = rounded(row["low"], digits), rounded(row["high"], digits)
    several = f"{low} to {high} on" if low != high else "on"
    over = f" ({several} {row['count']:.0f} recordings)" if row["count"] > 1 else ""
    baseline = f"{zero}: {rounded(row['zero'], digits)} {unit}"
    return f"{rounded(row['error'], digits)} {unit}{over}; {baseline}"

"""Errors by joint or component beside those of zero: averaged over recordings, and the largest."""

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


def percent(errors: pd.DataFrame, name: object) -> str:
    """Return the error of a joint or component in per cent of that of zero."""
    return f"{rounded(100 * float(errors['error'][name] / errors['zero'][name]), 0)} %"


def largest(rows: pd.DataFrame, error: str, zero: str, name: str = "joint") -> pd.Series:
    """Return place, recording, error and zero of the largest error, which no mean hides."""
    row = rows.loc[rows[error].idxmax()]
    places = {"place": row[name], "recording": row["recording"]}
    return pd.Series(places | {"error": row[error], "zero": row[zero]})


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


def stated_largest(row: pd.Series, unit: str, place: str, zero: str = ZERO) -> Number:
    """Return the largest error with its recording and its baseline."""
    return Number(
        name="largest error on a recording",
        value=float(row["error"]),
        unit=unit,
        place=f"{place} on {row['recording']}",
        baseline=float(row["zero"]),
        baseline_of=zero,
    )


def on_recording(row: pd.Series, digits: int, unit: str, which: str, zero: str = ZERO) -> str:
    """Return the largest error with its place, its recording and its baseline as a sentence.

    which: the words before the place, “on joint” or “along”.
    """
    error, beside = (rounded(row[name], digits) for name in ("error", "zero"))
    return (
        f"Largest error: {error} {unit} {which} {row['place']} on {row['recording']}; {zero}: "
        f"{beside} {unit}."
    )


def with_range(row: pd.Series, digits: int, unit: str, zero: str = ZERO) -> str:
    """Return an error, its range over recordings, and its baseline."""
    low, high = rounded(row["low"], digits), rounded(row["high"], digits)
    several = f"{low} to {high} on" if low != high else "on"
    over = f" ({several} {row['count']:.0f} recordings)" if row["count"] > 1 else ""
    baseline = f"{zero}: {rounded(row['zero'], digits)} {unit}"
    return f"{rounded(row['error'], digits)} {unit}{over}; {baseline}"

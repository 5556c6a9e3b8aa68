"""How each joint changed over time: friction, torque constants, offsets and noise."""

from collections.abc import Iterator
from datetime import date
from typing import Any

import pandas as pd

from ur5lib.report.cells import fixed, interval, number, rounded, significant
from ur5lib.report.document import Cell
from ur5lib.report.results import Body, Results

NAMES = {
    "coulomb": ("Coulomb friction", "Nm"),
    "viscous": ("viscous friction", "Nm s/rad"),
    "torque_constant": ("torque constant", "Nm/A"),
    "offset": ("offset", "Nm"),
    "noise": ("noise of the current", "A"),
}
LEAST = 0.5  # %, what temperature must account for to be mentioned


def dated(results: Results) -> list[str]:
    """Return the arms with enough dates."""
    return [*results.tables["health"]["robot"].unique()]


def told(results: Results) -> Iterator[str]:
    """Report how many dates there are, whether temperatures were recorded, and lost frames."""
    for robot in dated(results):
        rows = results.rows("health", robot=robot)
        lost = rows.loc[rows["quantity"] == "lost_frames", "value"].max()
        warmth = "" if rows["temperature_c"].notna().any() else "not "
        frames = f"A recording lost at most {rounded(100 * lost, 1)} % of its frames"
        yield (
            f"{robot} was recorded on {rows['date'].nunique()} dates, "
            f"{span(rows['date'].min(), rows['date'].max())}. Temperatures of its joints were "
            f"{warmth}recorded. {frames if lost else 'No frame was lost'}."
        )


def found(results: Results) -> Iterator[str]:
    """Yield a sentence for each change, the largest share of a value first."""
    changes = ranked(results)
    for row in changes.itertuples():
        yield f"{row.robot}, {sentence(row)}"
    if changes.empty and dated(results):
        yield "Nothing changed by more than chance explains."


def ranked(results: Results) -> pd.DataFrame:
    """Return the changes, the largest share of the value before first; offsets last."""
    rows = results.tables["health_changes"]
    share = (rows["size"] / rows["before"]).abs().mask(rows["quantity"] == "offset", 0.0)
    return rows.assign(share=share).sort_values("share", ascending=False, kind="stable")


def sentence(row: Any) -> str:
    """Return what changed on which joint, by how much, when, and what temperature adds."""
    name, unit = NAMES[row.quantity]
    rose = "rose" if row.size > 0 else "fell"
    verb, when = rose, f"between {days(row.first, row.last, 'and')}"
    if row.kind == "drift":
        verb, when = f"slowly {rose}", span(row.first, row.last)
    by = f"{significant(abs(row.size), 2)} ± {significant(row.std_error, 1)} {unit}"
    if row.quantity != "offset":
        error = share(row.std_error, row)
        digits = int(error < 1)
        by = f"{abs(share(row.size, row)):.{digits}f} ± {rounded(error, digits)} %"
    added = share(row.by_temperature, row)
    also = f"; temperature adds {fixed(added, 0)} %" if abs(added) >= LEAST else ""
    also = "" if row.quantity == "offset" else also
    return f"joint {row.joint}: {name} {verb} by {by} {when}{also}."


def share(size: float, row: Any) -> float:
    """Return a change in per cent of the value before it."""
    return float(100 * size / abs(row.before))


def changes(results: Results) -> Body:
    """Return the table of changes."""
    rows = [
        [
            Cell(row.robot),
            Cell(str(row.joint)),
            Cell(NAMES[row.quantity][0]),
            Cell(f"{row.kind}, {days(row.first, row.last, 'to')}"),
            Cell(f"{significant(row.before, 3)} {NAMES[row.quantity][1]}"),
            Cell(significant(row.size, 2).replace("-", "−")),
            Cell(interval(row.low, row.high, 3)),
            number(row.by_temperature, 3),
        ]
        for row in ranked(results).itertuples()
    ]
    header = ["arm", "joint", "quantity", "when", "before", "change", "95 %", "by temperature"]
    return Body(header, rows)


def span(first: str, last: str) -> str:
    """Return a period in words."""
    return f"from {days(first, last, 'to')}"


def days(first: str, last: str, word: str) -> str:
    """Return two dates in words, without repeating month and year."""
    _, month, year = day(last).split()
    return f"{day(first).removesuffix(f' {year}').removesuffix(f' {month}')} {word} {day(last)}"


def day(written: str) -> str:
    """Return a date in words."""
    known = date.fromisoformat(written)
    return f"{known.day} {known:%B %Y}"


def steps(results: Results) -> Iterator[str]:
    """Ask for a fit to what was recorded after the largest change."""
    rows = ranked(results)
    for row in rows[rows["share"] > 0][:1].itertuples():
        when = f"since {day(row.last)}" if row.kind == "jump" else "of late"
        told = f"{NAMES[row.quantity][0]} of joint {row.joint} has changed"
        yield f"Fit {row.robot} only to what was recorded {when}: {told}."

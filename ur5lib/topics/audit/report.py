"""The report's part on the sensor in an arm's wrist: its faults, in sentences and numbers."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.page.document import MOST_SHOWN
from ur5lib.report.page.formats import capital, fixed, with_error
from ur5lib.report.page.sentences import name, say
from ur5lib.report.results import Results

QUANTITY_WORDS = {"scale": "the scale", "drift": "the drift", "shift": "the shift by a contact"}
STATED_LIMITS = {"scale": "5 %", "drift": "1 N/min", "shift": "1 N"}
DIGITS_BY_UNIT = {"N": 2, "N/min": 2, "Nm": 3, "Nm/min": 3, "°": 2, "1": 4, "kg": 3, "m": 4}
MAX_RELATIVE_MASS_ERROR = (
    0.1  # largest relative error of a mass that the report proposes to declare
)
AuditRows = dict[str, pd.DataFrame]
"""The rows of audit.csv of one recording by quantity, each by component."""


def audited(results: Results) -> list[str]:
    """Return the first few recordings with a wrist sensor."""
    return [*map(str, results.tables["audit"]["recording"].unique())][:MOST_SHOWN]


def sentences(results: Results, recording: str) -> Iterator[str]:
    """Yield the verdicts on a recording's sensor, a sentence each."""
    for text in verdicts(results.rows("audit", recording=recording)):
        yield capital(f"{text}.")


def findings(results: Results) -> Iterator[str]:
    """Yield a sentence for each kind of fault of wrist sensors, with the recordings."""
    rows = results.rows("audit", verdict="wrong")
    for quantity, part in rows.groupby("quantity", sort=False):
        names = [*map(str, part["recording"].unique())]
        if results.many and len(names) > MOST_SHOWN:
            names[MOST_SHOWN:] = [f"{len(names) - MOST_SHOWN} more"]
        yield say("audit.fault", name=name(str(quantity), "audit"), names=names)


def values(results: Results, recording: str) -> pd.DataFrame:
    """Return every value of a recording's sensor, with its number of digits."""
    rows = results.rows("audit", recording=recording)
    rows = rows[rows["quantity"] != "free_time"].fillna({"component": "", "verdict": ""})
    return rows.assign(digits=rows["unit"].map(DIGITS_BY_UNIT))


def verdicts(rows: pd.DataFrame) -> Iterator[str]:
    """Yield sentences about one recording's sensor, from its rows of audit.csv."""
    filled = rows.fillna({"component": "", "verdict": ""}).set_index("component")
    audit = dict([*filled.groupby("quantity")])
    if len(filled) == 1:
        yield say("audit.short", seconds=filled["value"].iloc[0])
        return
    if "mass" in audit:
        yield from _sensor(audit)
    if "zero" in audit:
        zero, remaining = audit["zero"], audit["left_mass"].loc[""]
        force, found = say("audit.vector", values=zero["value"][:3]), {*zero["verdict"]}
        yield say("audit.zero", force=force, wrong="wrong" in found, unknown="unknown" in found)
        if remaining.verdict == "wrong":
            yield say("audit.left", left=_with_error(remaining))


def _sensor(audit: AuditRows) -> Iterator[str]:
    """Yield sentences about the raw reading, axis by axis and as a whole."""
    for axis in "xyz":
        parts = {"scale": axis, "drift": f"F{axis}", "shift": f"F{axis}"}
        judged = []
        for quantity, component in parts.items():
            if quantity in audit:
                row = audit[quantity].loc[component]
                words = {"word": QUANTITY_WORDS[quantity], "limit": STATED_LIMITS[quantity]}
                judged.append(say("audit.judged", row=row, value=_with_error(row), **words))
        yield say("audit.axis", axis=axis, parts=judged)
    if "scale" not in audit:
        yield say("audit.no scale")
    if "shift" not in audit:
        yield say("audit.no shift")
    turn = audit["turn"]
    vector = say("audit.vector", values=turn["value"])
    if (turn["verdict"] == "unknown").any():
        yield say("audit.turn unknown")
    elif (turn["verdict"] == "wrong").any():
        size = float((turn["value"] ** 2).sum() ** 0.5)
        yield say("audit.turn wrong", size=size, vector=vector, typed=vector.replace("−", "-"))
    else:
        yield say("audit.turn right", vector=vector)
    yield from _payload(audit)


def _with_error(row: pd.Series) -> str:
    """Return a value with its standard error and its unit."""
    unit = "" if row.unit == "1" else row.unit
    return with_error(row.value, row.std_error, unit)


def _payload(audit: AuditRows) -> Iterator[str]:
    """Yield the mass on the sensor beside the declared one, and the command that declares it.

    It differs from the declared one where none is declared, or the centre of mass is another, which
    no wrong scale of the sensor explains.
    """
    mass, center = audit["mass"].loc[""], audit["center_of_mass"]
    declared = None if pd.isna(mass.expected) else mass.expected
    certain = 0 < mass.std_error < MAX_RELATIVE_MASS_ERROR * mass.value
    place = ""
    if certain and ("scale" not in audit or (center["verdict"] == "wrong").any()):
        place = ", ".join(fixed(value, 3).replace("−", "-") for value in center["value"])
    words = {"mass": _with_error(mass), "kg": mass.value, "declared": declared, "place": place}
    yield say("audit.payload", **words)
    if "mass_by_currents" in audit:
        yield say("audit.by currents", by=audit["mass_by_currents"].loc[""])

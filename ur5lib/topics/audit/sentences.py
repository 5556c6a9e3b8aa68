"""The verdicts on the sensor in an arm's wrist in sentences, as `ur5 audit` prints them."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.records.wording import sentence
from ur5lib.report.stated import with_error
from ur5lib.topics.audit.report import is_to_declare

JUDGED = {  # by quantity: its words, and the limit of a right one
    "scale": ("the scale", "5 %"),
    "drift": ("the drift", "1 N/min"),
    "shift": ("the shift by a contact", "1 N"),
}
AuditRows = dict[str, pd.DataFrame]
"""The rows of audit.csv of one recording by quantity, each by component."""


def verdicts(rows: pd.DataFrame) -> Iterator[str]:
    """Yield sentences about one recording's sensor, from its rows of audit.csv."""
    words = rows.astype({"component": object, "verdict": object})  # also where all are empty
    filled = words.fillna({"component": "", "verdict": ""}).set_index("component")
    audit = dict([*filled.groupby("quantity")])
    if len(filled) == 1:
        yield sentence("audit too short", {"seconds": filled["value"].iloc[0]})
        return
    if "mass" in audit:
        yield from _sensor(audit)
    if "zero" in audit:
        yield from _controllers(audit["zero"], audit["left_mass"].loc[""])


def _sensor(audit: AuditRows) -> Iterator[str]:
    """Yield sentences about the raw reading, axis by axis and as a whole."""
    for axis in "xyz":
        components = {"scale": axis, "drift": f"F{axis}", "shift": f"F{axis}"}
        rows = {name: audit[name].loc[part] for name, part in components.items() if name in audit}
        parts = "; ".join(_judged(name, row) for name, row in rows.items())
        yield sentence("audit axis", {"axis": axis, "parts": parts})
    for name in ("scale", "shift"):
        if name not in audit:
            yield sentence(f"audit without {name}", {})
    turn = audit["turn"]
    found = next(own for own in ("unknown", "wrong", "right") if own in {*turn["verdict"], "right"})
    size = float((turn["value"] ** 2).sum() ** 0.5)
    yield sentence(f"audit turn {found}", {"size": size, "vector": _vector(turn["value"])})
    yield from _payload(audit)


def _judged(name: str, row: pd.Series) -> str:
    """Return the verdict on one quantity along one axis."""
    word, limit = JUDGED[name]
    words = {"word": word, "value": _with_error(row), "limit": limit}
    return sentence(f"audit {row.verdict}", words)


def _payload(audit: AuditRows) -> Iterator[str]:
    """Yield the mass on the sensor beside the declared one, the command that declares it, and that
    by the currents.
    """
    mass = audit["mass"].loc[""]
    declared = "none is" if pd.isna(mass.expected) else f"{mass.expected:g} kg are"
    words = {"mass": _with_error(mass), "declared": declared, "kg": mass.value}
    if is_to_declare(audit):
        place = ", ".join(f"{value:.3f}" for value in audit["center_of_mass"]["value"])
        yield sentence("audit other payload", words | {"place": place})
    else:
        yield sentence("audit payload", words)
    if "mass_by_currents" in audit:
        own = audit["mass_by_currents"].loc[""]
        yield sentence("audit mass by currents", {"low": own.low, "high": own.high})


def _controllers(zero: pd.DataFrame, remaining: pd.Series) -> Iterator[str]:
    """Yield sentences about the controller's force without contact."""
    found = next(own for own in ("unknown", "wrong", "right") if own in {*zero["verdict"], "right"})
    yield sentence(f"audit zero {found}", {"force": _vector(zero["value"][:3])})
    if remaining.verdict == "wrong":
        yield sentence("audit mass left", {"left": _with_error(remaining)})


def _vector(values: pd.Series) -> str:
    return ", ".join(f"{value:.1f}" for value in values)


def _with_error(row: pd.Series) -> str:
    """Return a value with its standard error and its unit."""
    unit = "" if row.unit == "1" else f" {row.unit}"
    return f"{with_error(row.value, row.std_error)}{unit}"

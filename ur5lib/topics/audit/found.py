"""What the audit of wrist sensors adds to findings and steps: their faults."""

from collections.abc import Iterator

from ur5lib.report.results import Results
from ur5lib.report.stated import Step, listed, quoted

TABLES = ("audit",)
NAMES = {  # names in sentences that differ from those in audit.csv
    "bias": "bias at the start",
    "turn": "turn of its axes",
    "mass": "mass on it",
    "center_of_mass": "centre of mass on it",
    "shift": "shift by a contact",
    "zero": "actual_TCP_force without contact",
    "left_mass": "mass left in actual_TCP_force",
    "mass_by_currents": "mass by the motors",
}


def findings(results: Results) -> Iterator[str]:
    """Report each kind of fault of wrist sensors, with the recordings."""
    rows = results.rows("audit", verdict="wrong")
    for quantity, part in rows.groupby("quantity", sort=False):
        names = quoted(part["recording"].unique())
        yield f"The wrist sensor on {names} has a wrong {_name(str(quantity))}."


def advice(results: Results) -> Iterator[Step]:
    """Ask to correct a wrong wrist sensor."""
    rows = results.rows("audit", verdict="wrong")
    if len(rows):
        kinds = listed([*map(_name, rows["quantity"].unique())])
        names = quoted(rows["recording"].unique())
        sentence = f"Correct the wrist sensor on {names}: wrong {kinds}."
        yield Step(sentence, f"ur5 audit {results.study.get('study', '')}")


def _name(quantity: str) -> str:
    return NAMES.get(quantity, quantity)

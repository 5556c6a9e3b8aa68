"""The numbers that are compared between two results, by topic: estimates, errors, findings."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from ur5lib.comparing.changes import Comparison, compare_errors, compare_estimates
from ur5lib.finished import FinishedStudy
from ur5lib.timeseries.metrics import NORMAL95

UNITS = {"torque_constant": "Nm/A", "viscous": "Nm s/rad", "load": ""}  # others: Nm
SEVERE = ["stop", "error", "warning"]
Compare = Callable[[FinishedStudy, FinishedStudy], list[Comparison]]


def compare(before: Path, after: Path) -> list[Comparison]:
    """Compare all numbers that the results of two studies, results/<study>, have in common.

    Raises InputError where a folder holds no results.
    """
    studies = FinishedStudy(before), FinishedStudy(after)
    return [one for topic in TOPICS.values() for one in topic(*studies)]


def friction(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare torque constants, offsets and friction that the data determine."""
    keys = ["robot", "joint", "parameter"]
    rows = _both(before, after, "friction", keys)
    rows = rows[(rows["determined_a"] == "yes") & (rows["determined_b"] == "yes")]
    for side in "ab":
        rows[f"half_{side}"] = (rows[f"high_{side}"] - rows[f"low_{side}"]) / 2
    names = [f"{r.robot}, joint {r.joint}, {_words(r.parameter)}" for r in rows.itertuples()]
    return compare_estimates(
        "friction", rows, names, [UNITS.get(name, "Nm") for name in rows["parameter"]]
    )


def model(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare base parameters that the data determine, and rotor inertias."""
    rows = _both(before, after, "parameters", ["robot", "parameter"])
    rows = rows[(rows["determined_a"] == "yes") & (rows["determined_b"] == "yes")]
    names = [f"{r.robot}, {r.parameter}" for r in rows.itertuples()]
    rotors = _both(before, after, "rotor_inertia", ["robot", "joint"])
    names += [f"{r.robot}, joint {r.joint}, rotor inertia" for r in rotors.itertuples()]
    units = [""] * len(rows) + ["kg m²"] * len(rotors)
    pairs = pd.concat([_halves(rows), _halves(rotors)], ignore_index=True)
    return compare_estimates("model", pairs, names, units)


def payload(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare the undeclared masses on the flange."""
    rows = _both(before, after, "payload", ["recording"])
    rows = _halves(rows.rename(columns={"mass_a": "value_a", "mass_b": "value_b"}))
    return compare_estimates("payload", rows, [*rows["recording"]], ["kg"] * len(rows))


def currents(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare the errors of predicted currents below 2 Hz."""
    rows = _both(before, after, "current_rmse", ["model", "recording", "joint"])
    rows = rows[rows["model"] == "fitted"]
    rows = rows.rename(columns={"rmse_2hz_a": "value_a", "rmse_2hz_b": "value_b"})
    names = [f"{r.recording}, joint {r.joint}" for r in rows.itertuples()]
    return compare_errors("currents", rows, names, "A")


def force(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare the errors of F^map in contact by their intervals over contacts."""
    keys = ["recording", "kind", "estimate", "during", "component"]
    rows = _both(before, after, "force_mae", keys)
    compared = (rows["kind"] == "compensated") & (rows["estimate"] == "Fmap")
    rows = rows[compared & (rows["during"] == "contact") & rows["component"].str.startswith("F")]
    for side in "ab":
        rows[f"value_{side}"] = rows[f"mae_{side}"]
        rows[f"half_{side}"] = (rows[f"mae_high_{side}"] - rows[f"mae_low_{side}"]) / 2
    names = [f"{r.recording}, {r.component}" for r in rows.itertuples()]
    return compare_estimates("force", rows, names, ["N"] * len(rows))


def data(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare the findings about the recordings' files, notes excepted."""
    counts = [_findings(study) for study in (before, after)]
    comparisons = []
    for key in sorted(counts[0].keys() | counts[1].keys()):
        old, new = (by_key.get(key, 0) for by_key in counts)
        comparisons.append(Comparison("data", key, str(old), str(new), old != new, old != new))
    return comparisons


TOPICS: dict[str, Compare] = {
    "data": data,
    "model": model,
    "friction": friction,
    "payload": payload,
    "currents": currents,
    "force": force,
}


def _both(
    before: FinishedStudy, after: FinishedStudy, table: str, keys: Sequence[str]
) -> pd.DataFrame:
    """Return the common rows of a table, its columns with the suffixes _a (before) and _b."""
    one, other = before.table(table), after.table(table)
    return one.merge(other, on=list(keys), suffixes=("_a", "_b"))


def _halves(rows: pd.DataFrame) -> pd.DataFrame:
    """Add half the width of the 95 % intervals, from `std_error`."""
    return rows.assign(**{f"half_{side}": NORMAL95 * rows[f"std_error_{side}"] for side in "ab"})


def _findings(study: FinishedStudy) -> dict[str, int]:
    rows = study.table("quality")
    rows = rows[np.isin(rows["severity"], SEVERE)]
    return {f"{r.recording}, {r.device}: {r.finding}": int(r.count) for r in rows.itertuples()}


def _words(name: str) -> str:
    return name.replace("_", " ")

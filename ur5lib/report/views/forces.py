"""Contact forces compared with the force sensor, their bands, and detected contacts."""

import pandas as pd

from ur5lib.force.estimators import GATED, LEADING, NEW, PUBLISHED
from ur5lib.force.trial_contacts import MAX_TRIAL_FORCE
from ur5lib.report.results import Results
from ur5lib.report.views.currents import loaded

FORCE_COMPONENTS = ["Fx", "Fy", "Fz"]
FORCE_STDS = [f"{name}_std" for name in FORCE_COMPONENTS]
SMALLEST_PUSHES = [f"smallest_force_95_{axis}" for axis in "xyz"]
REPORT_RANK = {
    name: place for place, name in enumerate([*NEW, *PUBLISHED])
}  # in the report's order


def compared(results: Results) -> list[str]:
    """Return recordings with printed errors, with a force sensor, then others with contact."""
    touched = results.with_role("contact", searched(results)["recording"])
    beside = [*results.listed("force_mae"), *results.listed("sensed")]
    return results.shown([*results.printed("force_mae", "printed_mae"), *beside, *touched])


def with_moments(results: Results) -> list[str]:
    """Return recordings on which the leading estimate determines a moment in contact."""
    rows = results.rows("force_mae", kind="compensated", during="contact", determined="yes")
    return results.shown([*leading(rows[rows["component"].str.startswith("n")])["recording"]])


def searched(results: Results) -> pd.DataFrame:
    """Return the detections by the estimates of this study, without published ones."""
    return results.rows("detection", estimate=GATED)


def leading(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the leading estimate: the first in the report's order."""
    rank = rows["estimate"].map(REPORT_RANK)
    return rows[rank == rank.min()]


def contact_errors(results: Results, recording: str) -> pd.DataFrame:
    """Return peak, impulse and onset of each contact, with the leading estimate's errors."""
    return leading(results.rows("contact_errors", recording=recording, component="norm"))


def contacts(results: Results, recording: str) -> pd.DataFrame:
    """Return the contacts that the leading estimate finds."""
    return results.rows("contacts", recording=recording, estimate=LEADING)


def smallest_pushes(results: Results) -> pd.DataFrame:
    """Return the smallest push along each axis that is detected, in motion and at rest."""
    rows = pushes_found(results)
    parts = []
    for prefix, state in (("", "in motion"), ("rest_", "at rest")):
        for axis in "xyz":
            force, std = (rows[f"smallest_force_{of}_{prefix}{axis}"] for of in ("95", "std"))
            part = {
                "state": state,
                "axis": axis,
                "force": force,
                "std": std,
                "most": MAX_TRIAL_FORCE,
            }
            parts.append(rows[["recording"]].assign(**part))
    return pd.concat([part for part in parts if part["force"].notna().any()] or parts[:1])


def pushes_found(results: Results) -> pd.DataFrame:
    """Return the smallest pushes that are detected on motions without an undeclared load."""
    rows = results.rows("detection", estimate=LEADING).dropna(subset=SMALLEST_PUSHES, how="all")
    return rows[~rows["recording"].isin(loaded(results)["recording"])]

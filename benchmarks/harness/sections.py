"""The page's sections on simulated arms and on contacts found, from tables in results/."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from benchmarks.harness.markdown import markdown
from benchmarks.harness.pushes import EACH, FORCES, PLACES
from benchmarks.harness.simulated import better_than_ours, refused_on_some, simulated_table
from ur5lib.force.estimators import ESTIMATES
from ur5lib.report.results import Results
from ur5lib.report.views.contacts import alarm_rates, classes
from ur5lib.tables import read_csv

JUDGED = ("Fmap", "Fu")  # the thesis's estimates find nothing at the thresholds of the rule


def simulated_section(path: Path) -> dict[str, Any] | None:
    """Return the section on simulated arms from its table, None where that is missing."""
    if not path.exists():
        return None
    table = read_csv(path)
    return {
        "title": f"{table['seed'].nunique()} seeds.",
        "arms": ", ".join(table["arm"].unique()),
        "pushes": EACH * len(PLACES),
        "forces": f"{FORCES[0]:g} to {FORCES[1]:g} N",
        "better": [*better_than_ours(table)],
        "refused": "; ".join(refused_on_some(table)),
        "table": simulated_table(table),
    }


def detection_tables(folders: Sequence[Path]) -> dict[str, str]:
    """Return the tables of contacts at a force sensor, and of alarms without a sensor."""
    studies = [judged(folder) for folder in folders]
    return {
        "found": found_table(pd.concat([*map(classes, studies)])),
        "alarms": alarm_table(pd.concat([*map(alarm_rates, studies)])),
    }


def found_table(rows: pd.DataFrame) -> str:
    """Return a line for each recording and estimate: found contacts by class of force, false and
    extra alarms, delay.
    """
    forces = sorted(rows["force_class_n"].unique())
    heads = ["recording", "estimate", "from [N]", *(f"≥ {force:g} N" for force in forces)]
    heads += ["false [1/min]", "extra", "free time in alarm [%]", "delay [s]"]
    lines = []
    for (recording, estimate), own in rows.groupby(["recording", "estimate"], sort=False):
        first, by_force = own.iloc[0], own.set_index("force_class_n")
        cells = [str(recording), ESTIMATES[str(estimate)], cell(first["threshold"] or None, ".1f")]
        cells += [
            found(by_force.loc[force]) if force in by_force.index else "–" for force in forces
        ]
        cells += [cell(first["false_alarms_per_min"], ".1f"), cell(first["extra_alarms"], ".0f")]
        cells += [cell(100 * first["free_time_in_alarm"], ".0f"), cell(first["median_delay_s"])]
        lines.append(cells)
    return markdown(heads, lines)


def found(row: pd.Series) -> str:
    """Return the numbers of found and of merged contacts."""
    merged = f", {row['merged']:.0f} merged" if row["merged"] > 0 else ""
    return f"{row['found']:.0f} of {row['contacts']:.0f}{merged}"


def alarm_table(rows: pd.DataFrame) -> str:
    """Return the alarms a minute by recording and estimate."""
    names = [name for name in ESTIMATES if name in {*rows["estimate"]}]
    lines = [
        [str(recording), *(cell(rate.get(name), ".1f") for name in names)]
        for recording, part in rows.groupby("recording", sort=False)
        for rate in [part.set_index("estimate")["alarms_per_min"]]
    ]
    return markdown(["recording", *(f"{ESTIMATES[name]} [1/min]" for name in names)], lines)


def cell(value: float | None, digits: str = ".2f") -> str:
    """Return a number, a dash where there is none."""
    return "–" if pd.isna(value) else f"{value:{digits}}"


def judged(folder: Path) -> Results:
    """Return the detections of a study on recordings with a sensor, or of the role `validate`."""
    study = yaml.safe_load((folder / "configuration.yaml").read_text())
    table = read_csv(folder / "tables" / "detection.csv")
    untouched = table["recording"].isin(Results(study, {}, folder).with_role("validate"))
    known = (table["force_class_n"].notna() | untouched) & table["estimate"].isin(JUDGED)
    return Results(study, {"detection": table[known]}, folder)

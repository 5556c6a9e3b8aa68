"""The page's sections on simulated arms and on contacts found, from tables in results/."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from benchmarks.harness.markdown import markdown
from benchmarks.harness.pushes import EACH, FORCES, PLACES
from benchmarks.harness.simulated import better_than_ours, refused_on_some, simulated_table
from ur5lib.report.page.compose import shown_table
from ur5lib.report.results import Results
from ur5lib.tables import read_csv

JUDGED = ("Fmap", "Fu")  # those of the thesis find nothing at the thresholds that the rule gives


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


def detection_tables(folders: Sequence[Path]) -> str:
    """Return, for each study, its contacts at a force sensor, and its alarms where none is."""
    tables = ("detection.classes", "detection.alarms")
    bodies = [shown_table(table, judged(folder)) for folder in folders for table in tables]
    texts = [(body.header, [[cell.text for cell in row] for row in body.rows]) for body in bodies]
    return "\n\n".join(markdown(header, rows) for header, rows in texts if rows)


def judged(folder: Path) -> Results:
    """Return the detections of a study on recordings with a sensor, or of the role `validate`."""
    study = yaml.safe_load((folder / "configuration.yaml").read_text())
    table = read_csv(folder / "tables" / "detection.csv")
    untouched = table["recording"].isin(Results(study, {}, folder).with_role("validate"))
    known = (table["force_class_n"].notna() | untouched) & table["estimate"].isin(JUDGED)
    return Results(study, {"detection": table[known]}, folder)

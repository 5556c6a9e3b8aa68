"""The page's tables of contacts found and of false alarms, from tables/detection.csv of studies."""

from collections.abc import Sequence
from pathlib import Path

import yaml

from benchmarks.harness.page import markdown
from ur5lib.report.compose import shown_table
from ur5lib.report.results import Results
from ur5lib.tables import read_csv


def detection_tables(folders: Sequence[Path]) -> str:
    """Return, for each study, its contacts at a force sensor, and its alarms where none is."""
    tables = ("forces.detections", "forces.alarms")
    bodies = [shown_table(table, judged(folder)) for folder in folders for table in tables]
    texts = [(body.header, [[cell.text for cell in row] for row in body.rows]) for body in bodies]
    return "\n\n".join(markdown(header, rows) for header, rows in texts if rows)


def judged(folder: Path) -> Results:
    """Return the detections of a study on recordings with a sensor, or of the role `validate`."""
    study = yaml.safe_load((folder / "configuration.yaml").read_text())
    table = read_csv(folder / "tables" / "detection.csv")
    untouched = table["recording"].isin(Results(study, {}, folder).with_role("validate"))
    known = table["force_class_n"].notna() | untouched
    return Results(study, {"detection": table[known]}, folder)

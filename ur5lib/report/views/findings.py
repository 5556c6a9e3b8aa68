"""The findings of a study in short sentences; every number comes from its tables."""

from collections.abc import Iterator

import pandas as pd
from scipy.special import bdtr, bdtrc

from ur5lib.pipeline.estimators import ESTIMATES
from ur5lib.report.document import MOST_SHOWN
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say
from ur5lib.report.tables.models import STOP
from ur5lib.report.verdicts.models import compare, named
from ur5lib.report.views import comparison
from ur5lib.report.views.audit import faults as wrist_sensor_faults
from ur5lib.report.views.contacts import (
    claim,
    counted,
    elsewhere,
    quiet,
    readings,
    undetermined_moments,
)
from ur5lib.report.views.currents import loaded
from ur5lib.report.views.forces import PUSHES, pushes_found, searched

IMPROBABLE = 0.025  # below this chance, the count of intervals that contain the truth is remarkable


def findings(results: Results) -> list[Sentence]:
    """Return the findings, one item each, or the sentence that there are none."""
    sentences = [
        *stop_signs(results),
        *nearest_model(results),
        *comparison.rebuilt(results),
        *loads_found(results),
        *counted(results),
        *elsewhere(results),
        *loads_taken_up(results),
        *readings(results),
        *_detection(results),
        *claim(results),
        *undetermined_moments(results.tables["force_mae"]),
        *wrist_sensor_faults(results),
        *beside_truth(results.rows("truth")),
        *comparison.changes(results),
    ]
    looked = len(searched(results)) or len(results.tables["sensed"])
    return sentences or [say("findings.none" if looked else "findings.unsearched")]


def stop_signs(results: Results) -> Iterator[Sentence]:
    """Report the contradictions because of which no forces are stated."""
    rows = results.rows("quality", severity="stop")
    for row in rows[:MOST_SHOWN].itertuples():
        yield say("findings.stop recording", row=row)
    if len(rows) > MOST_SHOWN:
        yield say("findings.stop signs", count=len(rows))
    for row in results.rows("remarks", step=STOP).itertuples():
        yield say("findings.stop arm", row=row)


def left_out(results: Results) -> list[Sentence]:
    """Return the results that this study's data do not allow, with the reasons."""
    return [*results.left_out, *left_out_fits(results), *_not_compared(results)]


def left_out_heading(results: Results) -> list[Sentence]:
    """Return the sentence above the list of `left_out`, if that has entries."""
    return [say("findings.left out heading")] if left_out(results) else []


def left_out_fits(results: Results) -> list[Sentence]:
    """Return the fits that were not possible, with the reasons."""
    remarks = results.tables["remarks"]
    rows = remarks[remarks["joint"].isna() & (remarks["step"] != STOP)].itertuples()
    return [say("findings.left out fit", row=row) for row in rows]


def _not_compared(results: Results) -> Iterator[Sentence]:
    """Report estimates that cannot be compared, for want of recordings or of a sensor."""
    if len(results.tables["friction"]) and not results.with_role("validate"):
        yield say("findings.not predicted")
    if len(searched(results)) and results.tables["sensed"].empty:
        yield say("findings.not compared")


def nearest_model(results: Results) -> Iterator[Sentence]:
    """Report the model that is closest to the controller's torques, if the models differ."""
    compared = compare(results)
    if compared is None or compared.rows["model"].nunique() < 2:
        return
    if not compared.differ:
        yield say("models.same")
    else:
        words = {"near": compared.near, "differ": compared.differ, "unseen": compared.unseen}
        yield say("models.nearest", best=[*map(named, compared.best)], **words)


def loads_found(results: Results) -> Iterator[Sentence]:
    """Report the recordings with an undeclared load."""
    for row in loaded(results)[:MOST_SHOWN].itertuples():
        yield say("findings.load", row=row)


def loads_taken_up(results: Results) -> Iterator[Sentence]:
    """Report the loads that the arm picked up during a run."""
    for row in results.rows("contacts", estimate="Fmap", kind="load")[:MOST_SHOWN].itertuples():
        yield say("findings.load taken up", row=row)


def _detection(results: Results) -> Iterator[Sentence]:
    """Report the contacts found, the false alarms, and the smallest push detected."""
    rows, name = results.rows("detection", estimate="Fmap"), ESTIMATES["Fmap"]
    least = rows[rows["force_class_n"] == rows["force_class_n"].min()]
    if len(least):
        found, count = (int(least[column].sum()) for column in ("found", "contacts"))
        yield say("findings.contacts", name=name, found=found, count=count)
    free = quiet(results)
    if len(free):
        yield say("findings.false alarms", name=name, rate=free["alarms_per_min"].mean())
    smallest = pushes_found(results)[PUSHES].median(skipna=False)
    if smallest.notna().all():
        yield say("findings.hardest", axis=smallest.idxmax()[-1], force=smallest.max())


def beside_truth(truth: pd.DataFrame) -> Iterator[Sentence]:
    """Report how many stated intervals contain the simulated truth, and the expected count."""
    stated = truth["within95"].dropna()
    if len(stated):
        count, held = len(stated), int((stated == "yes").sum())
        yield say("findings.truth", count=count, held=held)
        many, few = bdtrc(held - 1, count, 0.95), bdtr(held, count, 0.95)  # of independent values
        chance = min(many, few)
        surprise = {"chance": chance if chance < IMPROBABLE else None, "many": many < few}
        yield say("findings.right intervals", count=count, **surprise)

"""The first screen: one sentence, one figure, the next steps for the user, and the findings."""

from collections.abc import Iterator
from itertools import chain, islice
from typing import Any

import pandas as pd

from ur5lib.force.estimators import LEADING
from ur5lib.report.page import topics
from ur5lib.report.page.document import MOST_SHOWN
from ur5lib.report.page.formats import capital
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.report.views import contacts, currents, models
from ur5lib.report.views.cards import deciding, known
from ur5lib.report.views.forces import searched
from ur5lib.tidy.models import STOP

KINDS_OF_ADVICE = ("correction", "recording", "later")
MAX_STEPS = 3  # steps that a reader remembers
ABOVE, MISSED = "no contact missed from", "contacts missed, the largest"
EASIEST = "smallest trial push found, best motion and axis"
NOTHING: dict[str, Any] = {"contacts": {}, "pushes": {}, "force": {}, "constants": {}}
WIDEST = "widest 95 % interval of a constant, half of it"


def result(results: Results) -> Iterator[str]:
    """Say in one sentence which contacts are found, and how far off forces and constants are."""
    rows = results.rows("verdicts")
    first = {
        question: known(deciding(rows[rows["question"] == question]).to_dict())
        for question in ("contacts", "pushes", "force", "constants")
        if question in {*rows["question"]}
    }
    further = {
        name: [{"reason": ""} | known(row) for row in own[:1].to_dict("records")]
        for name in (ABOVE, MISSED, EASIEST, WIDEST)
        for own in [rows[rows["quantity"] == name]]
    }
    words: dict[str, Any] = {"above": further[ABOVE], "missed": further[MISSED]}
    doubted = rows[(rows["question"] == "force") & (rows["reason"] == "sensor_bias")]
    words |= {
        "easiest": further[EASIEST],
        "doubted": [*doubted[doubted["state"].isna()].itertuples()],
    }
    words = NOTHING | first | words | {"widest": further[WIDEST]}
    if not results.stopped() and (told := say("result.sentence", **words)):
        yield f"{capital(told).removesuffix(';')}."


def drawn(results: Results, wanted: str) -> list[str]:
    """Return the recording of the first figure, if that shows what is wanted."""
    kind, name = next(_figures(results), ("", ""))
    return [name] if kind == wanted else []


def first_figure(results: Results) -> dict[str, str]:
    """Return kind and recording of the first figure, empty where nothing over time is drawn."""
    return next(({"kind": kind, "recording": name} for kind, name in _figures(results)), {})


def worst_force(results: Results) -> list[str]:
    """Return the recording whose error of the force is the largest share of it, if it is drawn."""
    rows = results.rows("error_parts").sort_values("share", ascending=False)
    return results.shown([*rows["recording"]], 1)


def _figures(results: Results) -> Iterator[tuple[str, str]]:
    """Yield figures and their recordings, the most informative first.

    Forces beside a sensor in contact; currents in motion, if possible without a load; torques in
    motion; forces without a sensor; currents of the fit.
    """
    for name in results.shown([*contacts.decided(results)["recording"]]):
        yield "forces", name
    carrying = {*currents.loaded(results)["recording"]}
    for name in sorted(currents.predicted(results), key=carrying.__contains__):
        if results.moving(name):
            yield "currents", name
    for name in models.compared(results):
        if results.moving(name):
            yield "torques", name
    for name in results.shown(
        [*contacts.touched(results), *results.tables["contacts"]["recording"]]
    ):
        yield "forces", name
    fitted = results.rows("current_rmse", model="fitted")["recording"]
    for name in results.shown(results.with_role("fit", fitted)):
        yield "currents", name


def next_steps(results: Results) -> list[str]:
    """Return the most urgent steps: errors of the set-up first, then files, then recordings."""
    own = {kind: _steps(results.rows("advice", kind=kind)) for kind in KINDS_OF_ADVICE}
    of_topics = {"correction": topics.advice(results), "recording": topics.to_record(results)}
    steps = chain(*(chain(own[kind], of_topics.get(kind, ())) for kind in KINDS_OF_ADVICE))
    return [*islice(steps, MAX_STEPS)] or [say("steps.none")]


def _steps(rows: pd.DataFrame) -> Iterator[str]:
    """Yield the sentences of rows of advice.csv."""
    for row in rows.to_dict("records"):
        own = {str(name): None if pd.isna(value) else value for name, value in row.items()}
        joints = [*map(int, str(own.pop("joints") or "").split())]
        others = say("steps.others", recordings=own["recordings"])
        words = {"joints": joints, "others": f" {others}".rstrip()}
        yield say(f"steps.{own.pop('code')}", **own | words)


def findings(results: Results) -> list[str]:
    """Return the findings, one item each, or the sentence that there are none."""
    taken_up = results.rows("contacts", estimate=LEADING, kind="load")
    sentences = [
        *stop_signs(results),
        *currents.contradictions(results),
        *nearest_model(results),
        *_each("findings.load", currents.loaded(results)),
        *_each("findings.felt", results.rows("uses", purpose="fit", reason="felt")),
        *contacts.counted(results),
        *contacts.elsewhere(results),
        *_each("findings.load taken up", taken_up),
        *contacts.readings(results),
        *contacts.withheld(results),
        *contacts.undetermined_moments(results),
        *topics.findings(results),
    ]
    looked = len(searched(results)) or len(results.tables["sensed"])
    return sentences or [say("findings.none" if looked else "findings.unsearched")]


def stop_signs(results: Results) -> Iterator[str]:
    """Report the contradictions because of which no forces are stated."""
    rows = results.rows("quality", severity="stop")
    yield from _each("findings.stop recording", rows)
    if len(rows) > MOST_SHOWN:
        yield say("findings.stop signs", count=len(rows))
    for row in results.rows("remarks", step=STOP).itertuples():
        yield say("findings.stop arm", row=row)


def _each(template: str, rows: pd.DataFrame) -> Iterator[str]:
    """Report the first few rows of a table, a sentence each."""
    for row in rows[:MOST_SHOWN].itertuples():
        yield say(template, row=row)


def left_out(results: Results) -> list[str]:
    """Return results that the study's data do not allow or leave in doubt, with the reasons."""
    reasons = [*results.left_out, *left_out_fits(results)]
    if len(results.tables["friction"]) and not results.with_role("validate"):
        reasons.append(say("findings.not predicted"))
    if len(searched(results)) and results.tables["sensed"].empty:
        reasons.append(say("findings.not compared"))
    return reasons


def left_out_fits(results: Results) -> list[str]:
    """Return the fits that were not possible or are in doubt, with the reasons."""
    remarks = results.tables["remarks"]
    rows = remarks[remarks["joint"].isna() & (remarks["step"] != STOP)].itertuples()
    return [say("findings.left out fit", row=row) for row in rows]


def nearest_model(results: Results) -> Iterator[str]:
    """Report on how many joints the closest link models are closest."""
    rows = results.rows("verdicts", question="links").dropna(subset=["count", "of"])
    yield from _each("models.nearest", rows[rows["state"].isna()])

"""The first screen: verdicts, one figure, the next steps for the user, and the findings."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, islice

import pandas as pd

from ur5lib.force.estimators import LEADING
from ur5lib.identification.samples import MIN_UNITS
from ur5lib.report.page import topics
from ur5lib.report.page.document import MOST_SHOWN, Verdict
from ur5lib.report.page.formats import capital
from ur5lib.report.page.sentences import say
from ur5lib.report.results import AT_REST, Results
from ur5lib.report.views import (
    baseline,
    contacts,
    currents,
    models,
    motion,
    recordings,
)
from ur5lib.report.views.arms import Judge, by_arm
from ur5lib.report.views.forces import searched
from ur5lib.tidy.models import STOP

VERDICTS: list[Judge] = [
    contacts.judge_force,
    recordings.judge_files,
    by_arm(currents.judge_constants),
    by_arm(currents.judge_currents),
    by_arm(models.judge_links),
    by_arm(motion.judge_motion),
]
MAX_STEPS = 3  # steps that a reader remembers
HIGH_LOST_SHARE = 0.1  # share of lost frames from which a recording is worth repeating
ASKING_CODES = ["no motion", "one path", "few paths"]  # codes of remarks that ask for a recording


def verdicts(results: Results) -> list[Verdict]:
    """Return the verdicts, the force first, with what the study accepts under each."""
    accepted = [*recordings.accepted(results)]
    own = (verdict for judge in VERDICTS if (verdict := judge(results)))
    return [
        replace(verdict, evidence=" ".join(filter(None, [verdict.evidence, *accepted])))
        for verdict in (*own, *topics.cards(results))
    ]


def rules(_: Results) -> Iterator[str]:
    """Say by which rules the states of the cards were given."""
    known = {"skill": baseline.MIN_GOOD_SKILL, "link": models.MIN_LINK_SKILL}
    known |= {"ratio": baseline.BETTER_RIVAL_RATIO, "floors": baseline.MAX_GOOD_FLOORS}
    known |= {"coverage": baseline.MIN_GOOD_COVERAGE, "factor": baseline.MIN_GOOD_BAND_FACTOR}
    yield say("verdict.rules", **known, blind=contacts.MAX_BLIND_SHARE)


def result(results: Results) -> Iterator[str]:
    """Say in one sentence how far off forces and constants are."""
    forces = contacts.worst_in_contact(results)
    against, errors = currents.contradicting(results), currents.margins(results)
    if not results.stopped() and (len(forces) or len(errors) or against):
        paths = results.rows("remarks", code="one path", joint=[*errors.index])
        found = {"force": forces, "errors": errors, "against": against, "paths": paths}
        yield capital(say("result.sentence", **found))


def drawn(results: Results, wanted: str) -> list[str]:
    """Return the recording of the first figure, if that shows what is wanted."""
    kind, name = next(_figures(results), ("", ""))
    return [name] if kind == wanted else []


def worst_force(results: Results) -> list[str]:
    """Return the recording whose error of the force is the largest share of it, if it is drawn."""
    means = contacts.errors_in_contact(results).groupby("recording")[["mae", "mean_force"]].mean()
    shares = (means["mae"] / means["mean_force"]).sort_values(ascending=False)
    return results.shown([*shares.index], 1)


def _figures(results: Results) -> Iterator[tuple[str, str]]:
    """Yield figures and their recordings, the most informative first.

    Forces beside a sensor in contact; currents in motion, if possible without a load; torques in
    motion; forces without a sensor; currents of the fit.
    """
    for name in results.shown([*contacts.errors_in_contact(results)["recording"]]):
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
    of_files = faulty_files(results), topics.advice(results)
    steps = chain(corrections(results), *of_files, missing_recordings(results))
    return [*islice(steps, MAX_STEPS)] or [say("steps.none")]


def corrections(results: Results) -> Iterator[str]:
    """Ask to correct what contradicts the study: stop signs, contacts in fit recordings, payloads
    that only the currents show, and fitted constants beside prior knowledge.
    """
    for row in results.rows("quality", severity="stop")[:1].itertuples():
        yield say("steps.stop recording", file=results.file_of(row.recording), row=row)
    for row in results.rows("remarks", step=STOP)[:1].itertuples():
        yield say("steps.stop arm", row=row)
    sensed = results.rows("force_mae", during="contact")["recording"]
    if touched := results.with_role("fit", sensed):
        yield say("steps.touched", some=_some(touched))
    if felt := [name for name in contacts.felt_while_fitted(results) if name not in touched]:
        yield say("steps.felt", some=_some(felt))
    loads = currents.loaded(results)
    for row in loads[:1].itertuples():
        mass = {"mass": row.configured + row.mass, "std": row.std_error}
        some = _some([*loads["recording"]])
        yield say("steps.payload", some=some, recording=row.recording, **mass)
    yield from currents.explained(results)
    for robot, (shown, _) in _contradicted(results).items():
        if shown:
            yield say("steps.contradiction", robot=robot, numbers=shown)


def _contradicted(results: Results) -> dict[str, tuple[list[int], list[int]]]:
    """Return by arm the joints whose constants contradict the known ones for no known cause: those
    that gravity loads, which show it, and the others, whose currents hardly tell a constant.
    """
    found: dict[str, tuple[list[int], list[int]]] = {}
    rows = results.rows("remarks", code=currents.CONTRADICTION_CODES)
    for row in rows[rows["code"] != currents.EXPLAINED].itertuples():
        shows = row.joint in results.bearing.get(row.robot, [row.joint])
        found.setdefault(row.robot, ([], []))[not shows].append(int(row.joint))
    return found


def faulty_files(results: Results) -> Iterator[str]:
    """Name recordings that lost many frames, and those whose force sensor's bias is in doubt."""
    shares = recordings.lost_shares(results)
    lost = {name: share for name, share in shares.items() if share >= HIGH_LOST_SHARE}
    if lost:
        names = sorted(lost, key=lambda name: -lost[name])
        worst = {"share": lost[names[0]], "file": results.file_of(names[0])}
        yield say("steps.lossy", some=_some(names), **worst)
    if doubted := contacts.doubted_biases(results, [*results.roles()]):
        yield say("steps.doubted", some=_some(doubted))


def missing_recordings(results: Results) -> Iterator[str]:
    """Ask for recordings that would determine the undetermined or narrow the band of forces."""
    for robot in sorted(results.placeholders.difference(results.listed("parameters", "robot"))):
        refused = results.rows("remarks", robot=robot, step="identification")
        yield say("steps.unknown links", robot=robot, why="; ".join(refused["remark"]))
    for row in results.tables["excitation"].dropna(subset="motion").itertuples():
        motion = row.motion[0].lower() + row.motion[1:]
        yield say("steps.advised", robot=row.robot, motion=motion)
    remarks = results.rows("remarks", code=ASKING_CODES)
    outlooks = currents.outlooks(results)
    hardly = [robot for robot, pair in outlooks.items() if not currents.is_worthwhile(*pair)]
    for (robot, code), part in remarks.groupby(["robot", "code"], sort=False):
        if code == "few paths" and robot in hardly:
            continue  # the band would stay
        words = {"robot": robot, "numbers": part["joint"], "hardly": robot in hardly}
        yield say(f"steps.{code}", **words, few=MIN_UNITS)
    for robot, (_, light) in _contradicted(results).items():
        if light:
            yield say("steps.light", robot=robot, numbers=light, load=results.loads.get(robot))
    for role in ("fit", "validate"):
        if not results.with_role(role):
            yield say(f"steps.{role}", held=results.with_role(AT_REST))
    if results.tables["force_mae"].empty and not contacts.touched(results):
        yield say("steps.pushes")
    yield from topics.to_record(results)


def _some(names: list[str]) -> str:
    """Name the first recording, and count the others."""
    return say("steps.some", names=names)


def findings(results: Results) -> list[str]:
    """Return the findings, one item each, or the sentence that there are none."""
    taken_up = results.rows("contacts", estimate=LEADING, kind="load")
    sentences = [
        *stop_signs(results),
        *currents.contradictions(results),
        *nearest_model(results),
        *_each("findings.load", currents.loaded(results)),
        *(
            say("findings.felt", name=name)
            for name in contacts.felt_while_fitted(results)[:MOST_SHOWN]
        ),
        *contacts.counted(results),
        *contacts.elsewhere(results),
        *_each("findings.load taken up", taken_up),
        *contacts.readings(results),
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
    """Report the model that is closest to the controller's torques, if the models differ."""
    compared = models.compare(results)
    if compared is None or compared.rows["model"].nunique() < 2:
        return
    if not compared.differ:
        yield say("models.same")
    else:
        yield say("models.nearest", best=[*map(models.named, compared.best)], compared=compared)

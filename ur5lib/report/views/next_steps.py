"""The next steps for the user: what to record, declare or correct."""

from collections.abc import Iterator
from itertools import islice

from ur5lib.identification.samples import FEW
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say
from ur5lib.report.tables.models import STOP
from ur5lib.report.verdicts.recordings import lost_shares
from ur5lib.report.views import health
from ur5lib.report.views.contacts import touched
from ur5lib.report.views.currents import loaded

MOST = 3  # steps that a reader remembers
MANY_LOST = 0.1  # share of lost frames from which a recording is worth repeating
CONTRADICTIONS = ("unlikely constant", "current against constant")  # codes of remarks
ASKING = ("no motion", "one path", "few paths")  # codes of remarks that ask for a recording


def steps(results: Results) -> list[str]:
    """Return the most urgent steps: errors of the set-up first, then files, then recordings."""
    return [*islice(_all(results), MOST)] or [say("steps.none")]


def _all(results: Results) -> Iterator[Sentence]:
    """Yield every step, the most urgent first."""
    yield from stop_signs(results)
    yield from touched_while_fitted(results)
    yield from payloads(results)
    yield from contradictions(results)
    yield from lossy_files(results)
    yield from doubted_sensors(results)
    yield from health.steps(results)
    yield from missing_recordings(results)


def stop_signs(results: Results) -> Iterator[Sentence]:
    """Ask to correct the file or the entry that contradicts the study."""
    for row in results.rows("quality", severity="stop")[:1].itertuples():
        yield say("steps.stop recording", file=results.file_of(row.recording), row=row)
    for row in results.rows("remarks", step=STOP)[:1].itertuples():
        yield say("steps.stop arm", row=row)


def touched_while_fitted(results: Results) -> Iterator[Sentence]:
    """Name fit recordings on which the force sensor reads a contact."""
    touched = results.rows("force_mae", during="contact")["recording"]
    names = [name for name in results.with_role("fit") if name in {*touched}]
    if names:
        yield say("steps.touched", some=_some(names))


def payloads(results: Results) -> Iterator[Sentence]:
    """Ask for the payload that currents show and the study does not declare."""
    loads = loaded(results)
    for row in loads[:1].itertuples():
        mass = {"mass": row.configured + row.mass, "std": row.std_error}
        some = _some([*loads["recording"]])
        yield say("steps.payload", some=some, recording=row.recording, **mass)


def contradictions(results: Results) -> Iterator[Sentence]:
    """Ask to check arms whose fitted constants contradict prior knowledge."""
    rows = results.tables["remarks"].query("code in @CONTRADICTIONS")
    for robot, part in rows.groupby("robot", sort=False):
        yield say("steps.contradiction", robot=robot, numbers=part["joint"])


def lossy_files(results: Results) -> Iterator[Sentence]:
    """Name the recordings that lost many frames."""
    lost = {name: share for name, share in lost_shares(results).items() if share >= MANY_LOST}
    if lost:
        names = sorted(lost, key=lambda name: -lost[name])
        worst = {"share": lost[names[0]], "file": results.file_of(names[0])}
        yield say("steps.lossy", some=_some(names), **worst)


def doubted_sensors(results: Results) -> Iterator[Sentence]:
    """Ask for a quiet start where the force sensor's bias is in doubt."""
    rows = results.rows("quality", device="force", severity="warning")
    doubts = [*rows.loc[rows["finding"] == "offset", "recording"]]
    if doubts:
        yield say("steps.doubted", some=_some(doubts))


def missing_recordings(results: Results) -> Iterator[Sentence]:
    """Ask for recordings that would determine the undetermined."""
    for row in results.tables["excitation"].dropna(subset="motion").itertuples():
        motion = row.motion[0].lower() + row.motion[1:]
        yield say("steps.advised", robot=row.robot, motion=motion)
    yield from other_motions(results)
    if results.tables["friction"].empty and not results.with_role("fit"):
        yield say("steps.fit")
    if not results.with_role("validate"):
        yield say("steps.validate")
    if results.tables["force_mae"].empty and not touched(results):
        yield say("steps.pushes")


def other_motions(results: Results) -> Iterator[Sentence]:
    """Ask for the motions that are missing by the remarks of the fits."""
    rows = results.tables["remarks"].query("code in @ASKING")
    for (robot, code), part in rows.groupby(["robot", "code"], sort=False):
        words = {"robot": robot, "numbers": part["joint"], "several": len(part) > 1, "few": FEW}
        yield say(f"steps.{code}", **words)


def _some(names: list[str]) -> Sentence:
    """Name the first recording, and count the others."""
    return say("steps.some", names=names, more=len(names) - 1)

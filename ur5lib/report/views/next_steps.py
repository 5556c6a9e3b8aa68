"""What to do next: what to record, what to declare, which file to look at."""

from collections.abc import Iterator
from itertools import islice

from ur5lib.report.cells import joints, rounded
from ur5lib.report.results import Results
from ur5lib.report.tables.models import STOP
from ur5lib.report.verdicts.data_quality import lost_shares
from ur5lib.report.views import health, sensed
from ur5lib.report.views.currents import loaded

MOST = 3  # steps that a reader remembers
MANY_LOST = 0.1  # share of frames, from which a recording is worth repeating
PLURALS = {"moves ": "move ", "does ": "do ", "this joint": "these joints"}  # of remarks
NOTHING = "No finding asks for a correction or another recording."


def steps(results: Results) -> list[str]:
    """Return the most urgent steps: errors of the set-up first, then files, then recordings."""
    return [*islice(_all(results), MOST)] or [NOTHING]


def _all(results: Results) -> Iterator[str]:
    """Yield every step, the most urgent first."""
    yield from stop_signs(results)
    yield from touched_while_fitted(results)
    yield from payloads(results)
    yield from contradictions(results)
    yield from lossy_files(results)
    yield from doubted_sensors(results)
    yield from health.steps(results)
    yield from missing_recordings(results)


def stop_signs(results: Results) -> Iterator[str]:
    """Send the reader to what contradicts the study."""
    for row in results.rows("quality", severity="stop")[:1].itertuples():
        yield f"Correct {results.file_of(row.recording)} or its entry in the study: {row.detail}."
    for row in results.rows("remarks", step=STOP)[:1].itertuples():
        yield f"Correct the recordings of {row.robot} or its entry: {row.remark}."


def touched_while_fitted(results: Results) -> Iterator[str]:
    """Name fit recordings on which the force sensor reads a contact."""
    touched = results.rows("force_mae", during="contact")["recording"]
    names = [name for name in results.with_role("fit") if name in {*touched}]
    if names:
        yield (
            f"Check {_some(names)}: its role is fit, which means free of contact, but its force "
            "sensor reads contacts. Give it the role contact, or correct the sensor's file."
        )


def payloads(results: Results) -> Iterator[str]:
    """Ask for the payload that currents show and the study does not declare."""
    loads = loaded(results)
    for row in loads[:1].itertuples():
        mass = row.configured + row.mass
        yield (
            f"Declare the payload of {_some([*loads['recording']])}: the currents show "
            f"{rounded(mass, 2)} ± {rounded(row.std_error, 2)} kg on {row.recording}."
        )


def contradictions(results: Results) -> Iterator[str]:
    """Repeat what the fits found to contradict prior knowledge."""
    rows = results.tables["remarks"].dropna(subset="joint")
    rows = rows[rows["remark"].str.contains("contradicts")]
    for robot, part in rows.groupby("robot", sort=False):
        yield (
            f"Check columns, units and the name of the arm {robot}: torque constants contradict "
            f"the known ones ({joints(part['joint'])})."
        )


def lossy_files(results: Results) -> Iterator[str]:
    """Name the recordings that lost many frames."""
    lost = {name: share for name, share in lost_shares(results).items() if share >= MANY_LOST}
    if lost:
        names = sorted(lost, key=lambda name: -lost[name])
        yield (
            f"Look at the logging of {_some(names)}: {100 * lost[names[0]]:.0f} % of the frames of "
            f"{results.file_of(names[0])} are missing; record again."
        )


def doubted_sensors(results: Results) -> Iterator[str]:
    """Ask for a quiet start where the force sensor's bias is in doubt."""
    rows = results.rows("quality", device="force", severity="warning")
    doubts = [*rows.loc[rows["finding"] == "offset", "recording"]]
    if doubts:
        yield (
            f"Record some seconds in which nothing touches the tool: the bias of the force sensor "
            f"is uncertain on {_some(doubts)}."
        )


def missing_recordings(results: Results) -> Iterator[str]:
    """Ask for the recordings that would settle what is undetermined."""
    for row in results.tables["excitation"].dropna(subset="advice").itertuples():
        motion = row.advice.partition(" would determine ")[0]
        if motion.startswith(("Holding", "Moving")):  # else no motion helps
            yield (
                f"Record {row.robot} {motion[0].lower()}{motion[1:]}: that would determine more of "
                "its link parameters."
            )
    yield from other_motions(results)
    if results.tables["friction"].empty and not results.with_role("fit"):
        yield (
            "Record three to five motions without contact, along different paths, for the role "
            "fit: without fitted friction, forces from currents are not calibrated."
        )
    if not results.with_role("validate"):
        yield "Record a motion without contact for the role validate, which no fit sees."
    if results.tables["force_mae"].empty and not sensed.touched(results):
        yield "Record pushes beside a force sensor: only that judges the size of the forces."


def other_motions(results: Results) -> Iterator[str]:
    """Turn the remarks of the fits that ask for a recording into a request."""
    rows = results.tables["remarks"].dropna(subset="joint")
    for (robot, remark), part in rows.groupby(["robot", "remark"], sort=False):
        finding, _, request = remark.rpartition("; ")
        if request.startswith("record"):
            said = f"{finding.partition(':')[0]}: {request}"
            if len(part) > 1:
                for one, several in PLURALS.items():
                    said = said.replace(one, several)
            yield f"On {robot}, {joints(part['joint'])} {said}."


def _some(names: list[str]) -> str:
    """Name the first recording, and count the others."""
    others = len(names) - 1
    return names[0] + (f" and {others} other{'s' if others > 1 else ''}" if others else "")

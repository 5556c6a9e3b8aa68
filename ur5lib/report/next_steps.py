"""What to do next: the rows of advice.csv and what the topics propose, the most urgent first."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain, islice
from typing import Any, NamedTuple

import pandas as pd

from ur5lib.records.phrases import number
from ur5lib.records.verdicts import Asks
from ur5lib.report import topics
from ur5lib.report.results import Results
from ur5lib.report.stated import (
    Step,
    alarms_on,
    capital,
    claim,
    designing,
    joints,
    line,
    overruled,
    quoted,
    remedy,
)

MAX_STEPS = 3  # on the first screen
NO_PLACE = "[x, y, z]"  # in place of a centre of mass that the user must measure


class Asked(NamedTuple):
    """A row of advice.csv in the form in which functions of `ASKED` put it into a sentence.

    recording: the first of those concerned, "" for none; recordings: in words, that one and the
    number of others; several: whether there are others; joints: in words; detail: the finding,
    without the line that overrules it; value: the row's number; place: a load's centre of mass.
    """

    results: Results
    robot: str
    recording: str
    recordings: str
    several: bool
    joints: str
    detail: str
    value: float | None
    place: str

    def check(self, recording: str = "") -> str:
        """Return the command that shows what is wrong with the study or a recording."""
        return f"ur5 check {self.results.study.get('study', '')} {recording}".strip()

    def design(self) -> str:
        """Return the command that designs the next recording."""
        return designing(self.results, self.robot, self.value)


def next_steps(results: Results) -> list[Step]:
    """Return the most urgent steps: errors of the set-up first, then files, then recordings.

    A command is named once, with the most urgent sentence; a line of the study may serve several.
    """
    of_topics = {"correction": topics.advice(results), "recording": topics.to_record(results)}
    steps = chain(
        *(
            chain(_of_study(results, kind), of_topics.get(kind, ()))
            for kind in ("correction", "recording", "later")
        )
    )
    once = dict[str | Step, Step]()
    for step in steps:
        once.setdefault(step.command if step.command.startswith("ur5 ") else step, step)
    return [*islice(once.values(), MAX_STEPS)]


def _of_study(results: Results, kind: str) -> Iterator[Step]:
    """Yield a step for each row of advice.csv with a kind, such as correction or recording."""
    for row in results.rows("advice", kind=kind).to_dict("records"):
        known = {str(name): None if pd.isna(value) else value for name, value in row.items()}
        yield _step(results, known)


def _step(results: Results, row: dict[str, Any]) -> Step:
    """Return the step of a row of advice.csv; a line in its detail replaces the step's command."""
    detail, _ = overruled(row["detail"] or "")
    recording, count = row["recording"] or "", row["recordings"]
    asked = Asked(
        results,
        robot=row["robot"] or "",
        recording=recording,
        recordings=quoted([recording], count),
        several=count > 1,
        joints=_joints(results, row["robot"], row["joints"] or ""),
        detail=detail,
        value=row["value"],
        place=_center_of_mass(results, recording),
    )
    told = ASKED[row["code"]](asked)
    return replace(told, command=line(detail) or told.command)


def _joints(results: Results, robot: str | None, numbers: str) -> str:
    """Return joints of an arm in words; numbers: with blanks between them, as in advice.csv."""
    named = [*map(int, numbers.split())]
    if {*named} == {*results.rows("friction", robot=robot)["joint"]}:
        return "all joints"
    return joints(named) if named else ""


def _center_of_mass(results: Results, recording: str) -> str:
    """Return the centre of mass of a recording's load in the notation of a study."""
    rows = results.rows("payload", recording=recording, taken="yes", configured=0)
    places = rows[[f"center_of_mass_{axis}" for axis in "xyz"]].dropna().to_numpy()
    return f"[{', '.join(f'{part:.3f}' for part in places[0])}]" if len(places) else NO_PLACE


def _stop_recording(asked: Asked) -> Step:
    entry = "their entries" if asked.several else "its entry"
    wrong = f"Correct {asked.recordings} or {entry}"
    if known := remedy(asked.detail):
        wrong = f"On {asked.recordings}, {known}"
    return Step(f"{wrong}: {claim(asked.detail)}.", asked.check(asked.recording))


def _stop_arm(asked: Asked) -> Step:
    wrong = f"Correct the recordings or the description of {asked.robot}"
    if known := remedy(asked.detail):
        wrong = f"For {asked.robot}, {known}"
    return Step(f"{wrong}: {claim(asked.detail)}.", asked.check())


def _touched(asked: Asked) -> Step:
    sentence = (
        f"Give {asked.recordings} the role contact and record untouched motion instead: the force "
        "sensor reads contacts."
    )
    return Step(sentence, "role: contact")


def _felt(asked: Asked) -> Step:
    found = alarms_on(asked.results, asked.recording)
    sentence = (
        f"If something touches the arm on {asked.recordings} ({found}"
        f"{' on the first' * asked.several}), give it the role contact: the fit takes pushes for "
        "noise."
    )
    return Step(sentence, "role: contact")


def _hidden(asked: Asked) -> Step:
    count = int(asked.value or 0)
    others = f"; {count} more {'has' if count == 1 else 'have'} alarms, too"
    sentence = (
        f"If something touched the arm there, cut it off by `from_s` and `to_s`: "
        f"{claim(asked.detail)}{others * asked.several}."
    )
    return Step(sentence, asked.check())


def _payload(asked: Asked) -> Step:
    show = f"the {asked.results.effort.quantity}s show {number(asked.value, '.2g')} kg"
    sentence = (
        f"Weigh the loads on {asked.recordings} and declare each: {show} on the first."
        if asked.several
        else f"Weigh the load on {asked.recordings} and declare it: {show}."
    )
    if asked.several:
        return Step(sentence, f"ur5 payload {asked.results.study.get('study', '')}".strip())
    mass = number(asked.value, ".3g")
    return Step(sentence, f"payload: {{mass: {mass}, center_of_mass: {asked.place}}}")


def _explained(asked: Asked) -> Step:
    known = remedy(asked.detail)
    sentence = f"{known}: {claim(asked.detail)}." if known else f"{claim(asked.detail)}."
    return Step(capital(sentence), asked.check())


def _contradiction(asked: Asked) -> Step:
    sentence = (
        f"Check columns, units, payload and `robot` of {asked.robot}: the "
        f"{asked.results.effort.constant} of {asked.joints} contradicts the known one."
    )
    return Step(sentence, asked.check())


def _no_effort(asked: Asked) -> Step:
    effort = asked.results.effort
    sentence = (
        f"Record the arm's {effort.quantity}s on {asked.recordings}, or name their columns: "
        f"without them, no {effort.constant}, friction or force is known."
    )
    return Step(sentence, asked.check())


def _lossy(asked: Asked) -> Step:
    sentence = (
        f"Record {asked.recordings} anew with a repaired logger: up to "
        f"{100 * (asked.value or 0.0):.0f} % of the frames are missing."
    )
    return Step(sentence, asked.check(asked.recording))


def _doubted(asked: Asked) -> Step:
    sentence = (
        "Leave the tool untouched for some seconds of each recording: the sensor's bias is "
        f"uncertain on {asked.recordings}."
    )
    return Step(sentence)


def _unknown_links(asked: Asked) -> Step:
    sentence = (
        f"Describe the links of {asked.robot}, which its recordings do not determine: "
        f"{claim(asked.detail)}."
        if asked.detail
        else f"Record actual_torque of {asked.robot} on several paths, or describe its links: "
        "without them, nothing else is computed."
    )
    return Step(sentence, "role: fit")


def _no_motion(asked: Asked) -> Step:
    record = f"Record a motion of {asked.joints} of {asked.robot}"
    return Step(f"{record}: without motion, friction is unknown.", asked.design())


def _one_path(asked: Asked) -> Step:
    record = f"Record {asked.joints} of {asked.robot} on another path"
    return Step(f"{record}: on one path, nothing tests the error bars.", asked.design())


def _few_paths(asked: Asked) -> Step:
    record = f"Record {asked.joints} of {asked.robot} on more paths"
    return Step(f"{record}: few paths leave the error bars uncertain.", asked.design())


def _fit(asked: Asked) -> Step:
    unknown = (
        "friction is" if asked.detail else f"{asked.results.effort.constant}s and friction are"
    )
    sentence = (
        "Record three to five motions without contact, each on another path: "
        f"{unknown} known from other arms only."
    )
    return Step(sentence, "role: fit")


def _validate(asked: Asked) -> Step:
    record = "Record a motion without contact for the role validate"
    return Step(f"{record}: nothing tests the fit.", "role: validate")


def _advised(asked: Asked) -> Step:
    motion = f"{asked.detail[:1].lower()}{asked.detail[1:]}"
    sentence = f"Record {asked.robot} {motion} in many poses: this determines more of its links."
    return Step(sentence, asked.design())


def _light(asked: Asked) -> Step:
    joints_of = f"{asked.joints} of {asked.robot}"
    record = (
        f"Record {joints_of} faster, or with {number(asked.value, '.3g')} kg off the axis"
        if asked.value
        else f"Record faster motions of {joints_of}"
    )
    tested = f"gravity is too weak there to test the {asked.results.effort.constant}"
    return Step(f"{record}: {tested}.", asked.design())


def _pushes(asked: Asked) -> Step:
    record = "Record pushes with a force sensor"
    return Step(f"{record}: without one, the error of the force is unknown.", "role: contact")


ASKED: dict[Asks, Callable[[Asked], Step]] = {
    Asks.STOP_RECORDING: _stop_recording,
    Asks.STOP_ARM: _stop_arm,
    Asks.TOUCHED: _touched,
    Asks.FELT: _felt,
    Asks.HIDDEN: _hidden,
    Asks.PAYLOAD: _payload,
    Asks.EXPLAINED: _explained,
    Asks.CONTRADICTION: _contradiction,
    Asks.NO_EFFORT: _no_effort,
    Asks.LOSSY: _lossy,
    Asks.DOUBTED: _doubted,
    Asks.UNKNOWN_LINKS: _unknown_links,
    Asks.NO_MOTION: _no_motion,
    Asks.ONE_PATH: _one_path,
    Asks.FEW_PATHS: _few_paths,
    Asks.FIT: _fit,
    Asks.VALIDATE: _validate,
    Asks.ADVISED: _advised,
    Asks.LIGHT: _light,
    Asks.PUSHES: _pushes,
}

"""What to do next: the rows of advice.csv and what the topics propose, the most urgent first."""

from collections.abc import Iterator
from itertools import chain, islice
from typing import Any

import pandas as pd

from ur5lib.report import topics
from ur5lib.report.results import Results
from ur5lib.report.stated import (
    Step,
    claim,
    designing,
    joints,
    line,
    overruled,
    quoted,
    remedy,
    step,
)

MAX_STEPS = 3  # that a reader remembers
DESIGN = "ur5 excite"  # in the place of a command: the one that designs a recording
ASKED = {  # of the codes of advice.csv: the sentence, and the command or line that does it
    "stop_recording": ("wrong recording", "check of a recording"),
    "stop_arm": ("wrong arm", "check of a study"),
    "touched": ("touched, whatever its role", "role of contact"),
    "felt": ("felt, whatever its role", "role of contact"),
    "payload": ("load to weigh", "payload of an entry"),
    "explained": ("known cause", "check of a study"),
    "contradiction": ("constants to check", "check of a study"),
    "lossy": ("logging to repair", "check of a recording"),
    "doubted": ("bias to determine", ""),
    "unknown_links": ("torques for links", "role of fit"),
    "no_motion": ("joints to move", DESIGN),
    "one_path": ("another path", DESIGN),
    "few_paths": ("more paths", DESIGN),
    "fit": ("motions to fit", "role of fit"),
    "validate": ("motion to validate", "role of validate"),
    "advised": ("motion for links", DESIGN),
    "light": ("faster joints", DESIGN),
    "pushes": ("pushes to record", "role of contact"),
}
MORE = {  # of codes: the sentence where a value is known
    "payload": ("several", "loads to weigh"),
    "stop_recording": ("remedy", "remedy of a recording"),
    "stop_arm": ("remedy", "remedy of an arm"),
    "explained": ("remedy", "remedy of a cause"),
    "unknown_links": ("detail", "links to describe"),
    "fit": ("detail", "motions to fit friction"),
    "light": ("value", "loaded joints"),
}
NO_PLACE = "[x, y, z]"  # of loads whose centres of mass are to be measured


def next_steps(results: Results) -> list[Step]:
    """Return the most urgent steps: errors of the set-up first, then files, then recordings."""
    of_topics = {"correction": topics.advice(results), "recording": topics.to_record(results)}
    steps = chain(
        *(
            chain(_of_study(results, kind), of_topics.get(kind, ()))
            for kind in ("correction", "recording", "later")
        )
    )
    return [*islice(steps, MAX_STEPS)]


def _of_study(results: Results, kind: str) -> Iterator[Step]:
    """Yield the steps of a kind of rows of advice.csv."""
    for row in results.rows("advice", kind=kind).to_dict("records"):
        known = {str(name): None if pd.isna(value) else value for name, value in row.items()}
        yield _step(results, known)


def _step(results: Results, row: dict[str, Any]) -> Step:
    """Return the step of a row of advice.csv."""
    told, command = ASKED[row["code"]]
    known, instead = MORE.get(row["code"], ("", ""))
    words = _words(results, row)
    if command == DESIGN:
        command = designing(results, row["robot"], row["value"])
    return step(results, instead if words.get(known) else told, words["line"] or command, **words)


def _words(results: Results, row: dict[str, Any]) -> dict[str, Any]:
    """Return the values in the sentences of a row of advice.csv."""
    detail, _ = overruled(row["detail"] or "")
    recording = row["recording"] or ""
    return row | {
        "detail": detail,
        "several": row["recordings"] > 1,
        "motion": f"{detail[:1].lower()}{detail[1:]}",
        "claim": claim(detail),
        "remedy": remedy(detail),
        "line": line(detail),
        "recordings": quoted([recording], row["recordings"]),
        "joints": _joints(results, row["robot"], row["joints"] or ""),
        "percent": 100 * (row["value"] or 0.0),
        "place": _center_of_mass(results, recording) if row["recordings"] == 1 else NO_PLACE,
    }


def _joints(results: Results, robot: str | None, numbers: str) -> str:
    """Return joints of an arm in words."""
    named = [*map(int, numbers.split())]
    if {*named} == {*results.rows("friction", robot=robot)["joint"]}:
        return "all joints"
    return joints(named) if named else ""


def _center_of_mass(results: Results, recording: str) -> str:
    """Return the centre of mass of the load on a recording, as a study writes it."""
    rows = results.rows("payload", recording=recording, taken="yes", configured=0)
    places = rows[[f"center_of_mass_{axis}" for axis in "xyz"]].dropna().to_numpy()
    return f"[{', '.join(f'{part:.3f}' for part in places[0])}]" if len(places) else NO_PLACE

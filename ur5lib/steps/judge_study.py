"""Judge a study by its tables: what may be used, which number decides, and why it is not better."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from ur5lib.judging import constants, currents, force, links, motion, recordings
from ur5lib.judging.advice import advice
from ur5lib.judging.contacts import (
    false_alarms,
    judge_alarms,
    judge_contacts,
    judge_pushes,
    noticed,
)
from ur5lib.judging.errors import STATES_BY_SEVERITY, severest
from ur5lib.judging.study import StudyTables, read_tables
from ur5lib.records.verdicts import (
    Advice,
    ErrorParts,
    FalseAlarms,
    JudgedError,
    ModelError,
    Noticed,
    RecordingUse,
    Verdict,
)
from ur5lib.robots.description import Robot
from ur5lib.tables import read_csv

OF_STUDY = (recordings.judge_recordings, force.judge_force, judge_contacts, judge_alarms)
OF_ARM = (
    constants.judge_constants,
    currents.judge_currents,
    links.judge_links,
    constants.judge_gravity,
    constants.judge_load,
    motion.judge_motion,
    judge_pushes,
)


class Judged(NamedTuple):
    """The verdicts on a study, and the tables that they are based on."""

    verdicts: list[Verdict]
    uses: list[RecordingUse]
    judged_errors: list[JudgedError]
    model_errors: list[ModelError]
    error_parts: list[ErrorParts]
    noticed: list[Noticed]
    false_alarms: list[FalseAlarms]
    advice: list[Advice]


def judge_study(
    study: str, tables: list[Path], described: Mapping[str, Robot], of_topics: list[Path]
) -> Judged:
    """Return the verdicts on a study.

    study: its configuration as YAML; described: its arms; of_topics: files with verdicts of topics,
    in the folders of the arms.
    """
    known = read_tables(study, tables, [*described.values()])
    found = judged(known)
    return found._replace(verdicts=[*found.verdicts, *with_study(verdicts_of(of_topics))])


def judged(study: StudyTables) -> Judged:
    """Return the verdicts on a study, without those of topics."""
    own = {robot: study.of_arm(robot) for robot in study.robots()}
    rows = [row for judge in OF_STUDY for row in judge(study)]
    for judge in OF_ARM:
        rows += with_study(row for robot, arm in own.items() for row in judge(arm, robot))
    errors = (links.errors, currents.errors, motion.errors)
    return Judged(
        verdicts=rows,
        uses=[*recordings.uses(study)],
        judged_errors=[
            one for of in errors for robot, arm in own.items() for one in of(arm, robot)
        ],
        model_errors=[one for robot, arm in own.items() for one in links.model_errors(arm, robot)],
        error_parts=[*force.error_parts(study)],
        noticed=[*noticed(study)],
        false_alarms=[*false_alarms(study)],
        advice=[*advice(study)],
    )


def with_study(rows: Iterable[Verdict]) -> Iterator[Verdict]:
    """Yield the verdicts on arms unchanged; for a question with verdicts on several arms, also the
    most severe of these as the verdict on the study.
    """
    known = [*rows]
    yield from known
    for question in dict.fromkeys(row.question for row in known):
        own = [row for row in known if row.question == question and row.rank == 1 and row.state]
        if len(own) > 1:
            gravest = min(own, key=lambda row: STATES_BY_SEVERITY.index(row.state or "good"))
            yield replace(gravest, arm="", state=severest(row.state for row in own))


def verdicts_of(files: Iterable[Path]) -> Iterator[Verdict]:
    """Yield the verdicts of topics, each file in the folder of its arm."""
    counts = {"joint", "rank", "count", "of"}
    for path in files:
        for row in read_csv(path).to_dict("records"):
            known = {str(name): value for name, value in row.items() if pd.notna(value)}
            known |= {name: int(known[name]) for name in counts & known.keys()}
            yield Verdict(**known | {"arm": path.parent.name})

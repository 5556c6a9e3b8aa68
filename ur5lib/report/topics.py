"""What the topics of a study add to its report, found by a loop over their folders.

The module `found` in the folder of a topic may have functions of the study's results: `advice`, the
next steps; `to_record`, a recording to make if nothing is more urgent; `findings`; and
`shown_first`, the recordings with which a table's figures begin. They are called if the study has
the tables that the module's `TABLES` names.
"""

from collections.abc import Iterator
from types import ModuleType

from ur5lib.report.results import Results
from ur5lib.report.stated import Step
from ur5lib.workspace.topics import modules_of_topics


def advice(results: Results) -> Iterator[Step]:
    """Yield the next steps that the topics propose."""
    for topic in _asked(results, "advice"):
        yield from topic.advice(results)


def to_record(results: Results) -> Iterator[Step]:
    """Yield the recordings that the topics propose, for use if nothing is more urgent."""
    for topic in _asked(results, "to_record"):
        yield from topic.to_record(results)


def findings(results: Results) -> Iterator[tuple[str, list[str]]]:
    """Yield for each topic the name of the table with all findings, and the findings to report."""
    for topic in _asked(results, "findings"):
        yield topic.TABLES[0], [*topic.findings(results)]


def shown_first(results: Results, table: str) -> list[str]:
    """Return the recordings with rows of a table that topics want to be shown first."""
    asked = _asked(results, "shown_first")
    return [name for topic in asked for name in topic.shown_first(results, table)]


def _asked(results: Results, slot: str) -> Iterator[ModuleType]:
    """Yield the modules `found` of the topics that have a function named `slot`, if the study has
    their tables.
    """
    for topic in modules_of_topics("found").values():
        if hasattr(topic, slot) and {*topic.TABLES} <= results.tables.keys():
            yield topic

"""What the topics of a study add to its report: their functions, found by a loop over folders.

The module `report` in the folder of a topic has the functions that its `report.yaml` names, and at
most three for the first screen: `advice`, what to do next; `to_record`, what to record where
nothing is more urgent; `findings`. A verdict of a topic is a row of verdicts.csv: a step writes it
into a file `<name>.verdicts.csv` of an arm.
"""

from collections.abc import Iterator
from functools import cache
from importlib import import_module
from types import ModuleType

from ur5lib.report.page.document import topic_pages
from ur5lib.report.results import Results
from ur5lib.workspace.places import PACKAGE


@cache
def functions() -> dict[str, ModuleType]:
    """Return the functions of each topic, by the name of its folder, in the order of sections."""
    has_some = (name for name in topic_pages() if (PACKAGE / f"topics/{name}/report.py").is_file())
    return {name: import_module(f"ur5lib.topics.{name}.report") for name in has_some}


def advice(results: Results) -> Iterator[str]:
    """Yield what the topics propose to do next."""
    for topic in _asked(results, "advice"):
        yield from topic.advice(results)


def to_record(results: Results) -> Iterator[str]:
    """Yield what the topics propose to record, where nothing is more urgent."""
    for topic in _asked(results, "to_record"):
        yield from topic.to_record(results)


def findings(results: Results) -> Iterator[str]:
    """Yield the topics' findings."""
    for topic in _asked(results, "findings"):
        yield from topic.findings(results)


def _asked(results: Results, slot: str) -> Iterator[ModuleType]:
    """Yield the topics that have a function and the tables that they need."""
    for name, own in functions().items():
        if hasattr(own, slot) and {*topic_pages()[name].needs} <= results.tables.keys():
            yield own

"""A comparison of two results as lines of text, as rows of a table and as JUnit XML."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree

from ur5lib.comparing.changes import Comparison
from ur5lib.comparing.topics import TOPICS
from ur5lib.tables import write_text

COLUMNS = ["study", "topic", "name", "before", "after", "differs", "changed"]


def account(found: Sequence[Comparison]) -> Iterator[str]:
    """Yield lines of text: for each topic the number of comparisons, then each change."""
    for topic in TOPICS:
        its = [one for one in found if one.topic == topic]
        if not its:
            yield f"{topic}: nothing to compare"
            continue
        differ = sum(one.differs for one in its)
        changed = [one for one in its if one.changed]
        yield f"{topic}: {len(its)} compared, {differ} beyond their error, {len(changed)} changed"
        yield from (f"  {one.sentence()}" for one in changed)


def rows(study: str, found: Sequence[Comparison]) -> Iterator[dict[str, str]]:
    """Yield each comparison as a row of changes.csv; study: name of the study compared with."""
    for one in found:
        row = {"study": study, "topic": one.topic, "name": one.name}
        told = {"before": one.before, "after": one.after}
        known = {"differs": one.differs, "changed": one.changed}
        yield row | told | {name: "yes" if holds else "no" for name, holds in known.items()}


def write_junit(found: Sequence[Comparison], path: Path) -> None:
    """Write JUnit XML with one test case per comparison, which fails if the number has changed."""
    suites = ElementTree.Element("testsuites")
    for topic in TOPICS:
        its = [one for one in found if one.topic == topic]
        failures = str(sum(one.changed for one in its))
        counts = {"tests": str(len(its)), "failures": failures}
        suite = ElementTree.SubElement(suites, "testsuite", {"name": topic} | counts)
        for one in its:
            case = ElementTree.SubElement(suite, "testcase", classname=topic, name=one.name)
            if one.changed:
                ElementTree.SubElement(case, "failure", message=one.sentence())
    write_text(ElementTree.tostring(suites, encoding="unicode", xml_declaration=True), path)

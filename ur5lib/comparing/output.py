"""Output of comparisons: lines of text, rows of a table, JUnit XML."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree

from ur5lib.comparing.changes import Comparison
from ur5lib.comparing.topics import TOPICS
from ur5lib.tables import write_text

COLUMNS = ["study", "topic", "name", "before", "after", "differs", "changed"]


def lines(comparisons: Sequence[Comparison]) -> Iterator[str]:
    """Yield lines of text: for each topic the number of comparisons, then each change."""
    for topic in TOPICS:
        in_topic = [one for one in comparisons if one.topic == topic]
        if not in_topic:
            yield f"{topic}: nothing to compare"
            continue
        differ = sum(one.differs for one in in_topic)
        changed = [one for one in in_topic if one.changed]
        count = len(in_topic)
        yield f"{topic}: {count} compared, {differ} beyond their error, {len(changed)} changed"
        yield from (f"  {one.sentence()}" for one in changed)


def rows(study: str, comparisons: Sequence[Comparison]) -> Iterator[dict[str, str]]:
    """Yield each comparison as a row of changes.csv; study: name of the study compared with."""
    for one in comparisons:
        row = {"study": study, "topic": one.topic, "name": one.name}
        row |= {"before": one.before, "after": one.after}
        verdicts = {"differs": one.differs, "changed": one.changed}
        yield row | {name: "yes" if holds else "no" for name, holds in verdicts.items()}


def write_junit(comparisons: Sequence[Comparison], path: Path) -> None:
    """Write JUnit XML with one test case per comparison, which fails if the number has changed."""
    suites = ElementTree.Element("testsuites")
    for topic in TOPICS:
        in_topic = [one for one in comparisons if one.topic == topic]
        failures = str(sum(one.changed for one in in_topic))
        counts = {"tests": str(len(in_topic)), "failures": failures}
        suite = ElementTree.SubElement(suites, "testsuite", {"name": topic} | counts)
        for one in in_topic:
            case = ElementTree.SubElement(suite, "testcase", classname=topic, name=one.name)
            if one.changed:
                ElementTree.SubElement(case, "failure", message=one.sentence())
    write_text(ElementTree.tostring(suites, encoding="unicode", xml_declaration=True), path)

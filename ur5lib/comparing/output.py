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
        in_topic = [comparison for comparison in comparisons if comparison.topic == topic]
        if not in_topic:
            yield f"{topic}: nothing to compare"
            continue
        differ = sum(comparison.differs for comparison in in_topic)
        changed = [comparison for comparison in in_topic if comparison.changed]
        count = len(in_topic)
        yield f"{topic}: {count} compared, {differ} beyond their error, {len(changed)} changed"
        yield from (f"  {comparison.sentence()}" for comparison in changed)


def rows(study: str, comparisons: Sequence[Comparison]) -> Iterator[dict[str, str]]:
    """Yield each comparison as a row of changes.csv; study: name of the study compared with."""
    for comparison in comparisons:
        row = {"study": study, "topic": comparison.topic, "name": comparison.name}
        row |= {"before": comparison.before, "after": comparison.after}
        verdicts = {"differs": comparison.differs, "changed": comparison.changed}
        yield row | {name: "yes" if holds else "no" for name, holds in verdicts.items()}


def write_junit(comparisons: Sequence[Comparison], path: Path) -> None:
    """Write JUnit XML with one test case per comparison, which fails if the number has changed."""
    suites = ElementTree.Element("testsuites")
    for topic in TOPICS:
        in_topic = [comparison for comparison in comparisons if comparison.topic == topic]
        failures = str(sum(comparison.changed for comparison in in_topic))
        counts = {"tests": str(len(in_topic)), "failures": failures}
        suite = ElementTree.SubElement(suites, "testsuite", {"name": topic} | counts)
        for comparison in in_topic:
            case = ElementTree.SubElement(suite, "testcase", classname=topic, name=comparison.name)
            if comparison.changed:
                ElementTree.SubElement(case, "failure", message=comparison.sentence())
    write_text(ElementTree.tostring(suites, encoding="unicode", xml_declaration=True), path)

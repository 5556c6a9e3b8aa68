"""The command `ur5 compare`."""

from pathlib import Path
from typing import Annotated

import typer

from ur5lib.commands.arguments import AsJson, Results, as_text, print_lines
from ur5lib.errors import unknown


def compare(
    before: Results,
    after: Results,
    fail_on: Annotated[
        str, typer.Option(help="topics whose change gives exit status 1, e.g. force,currents")
    ] = "",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="JUnit XML file to write")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List what changed between two results by more than its error.

    Example: ur5 compare monday tuesday --fail-on force,currents
    """
    from ur5lib.topics.compare.comparison import TOPICS, lines, write_junit  # slow to import
    from ur5lib.topics.compare.comparison import compare as compare_results

    topics = [topic for topic in fail_on.split(",") if topic]
    for topic in topics:
        if topic not in TOPICS:
            raise unknown("topic", topic, TOPICS)
    comparisons = compare_results(before, after)
    print_lines([as_text(comparisons)] if as_json else lines(comparisons))
    if output:
        write_junit(comparisons, output)
    if any(each.changed and each.topic in topics for each in comparisons):
        raise SystemExit(1)

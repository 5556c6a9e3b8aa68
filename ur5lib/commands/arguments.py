"""Arguments that several commands of `ur5` take, and how their answers are printed."""

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from ur5lib.study.address import results_folder, study_file

ADDRESS_HELP = "its name, its YAML file, or its folder of results"
STUDY_HELP = f"a study: {ADDRESS_HELP}"
StudyFile = Annotated[Path, typer.Argument(parser=study_file, help=STUDY_HELP, metavar="STUDY")]
Results = Annotated[Path, typer.Argument(parser=results_folder, help=STUDY_HELP, metavar="STUDY")]
AsJson = Annotated[bool, typer.Option("--json", help="print the answer as JSON")]


def as_text(answer: object) -> str:
    """Return an answer as JSON."""
    from ur5lib.tables import json_text

    return json_text(answer).rstrip()


def print_lines(lines: Iterable[object]) -> None:
    """Print each line as soon as there is one."""
    for line in lines:
        typer.echo(line)

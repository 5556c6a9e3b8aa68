"""Where the results come from: code, versions, files, times, configuration."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pandas as pd
import yaml

from ur5lib.report.cells import number
from ur5lib.report.document import Cell
from ur5lib.report.results import MOST_ROWS, Body, Results

CODE_WIDTH = 110  # characters of a line of the PDF


def commit(results: Results) -> Iterator[str]:
    """Which code made the results."""
    yield f"Made by commit {results.commit}."


def versions(results: Results) -> Body:
    """Versions of what the numbers depend on."""
    rows = [[Cell(name), Cell(version)] for name, version in results.versions.items()]
    return Body(["package", "version"], rows)


def files(results: Results) -> Body:
    """What each recording was read from."""
    rows = [
        [Cell(file.recording), Cell(file.file), Cell(file.sha256[:16])]
        for file in results.tables["files"].itertuples()
    ]
    return Body(["recording", "file", "SHA-256 begins"], rows)


def run_times(results: Results) -> Body:
    """How long each step took, and how much of that was start-up."""
    times = results.tables["run_times"]
    rows = [
        [
            Cell(step.step),
            Cell(str(step.jobs)),
            number(step.wall_s, 1),
            number(step.cpu_s, 1),
            number(step.start_up_s, 1),
            Cell(step.first_end.replace("T", " ")),
            Cell(step.last_end.replace("T", " ")),
        ]
        for step in times.itertuples()
    ]
    header = ["step", "jobs", "wall [s]", "processor [s]", "of it start-up [s]"]
    return Body([*header, "first ended (UTC)", "last ended (UTC)"], rows)


def total_time(results: Results) -> Iterator[str]:
    """All jobs together."""
    times: pd.DataFrame = results.tables["run_times"]
    if len(times):
        whole, start_up = times["cpu_s"].sum(), times["start_up_s"].sum()
        yield (
            f"The {times['jobs'].sum()} jobs took {whole:.0f} s of processor time, "
            f"{start_up:.0f} s of them for start-up: Python, its packages and, where dynamics is "
            "computed, torch. Snakemake's own time and this report's come on top."
        )


def configuration_heading(results: Results) -> Iterator[str]:
    """Opens the configuration."""
    first = f", of the first {MOST_ROWS} recordings" if _recordings(results)[MOST_ROWS:] else ""
    yield f"The configuration, with every default filled in{first}; configuration.yaml has all:"


def configuration(results: Results) -> str:
    """The study, with every default filled in."""
    lines = [_Line(recording) for recording in _recordings(results)[:MOST_ROWS]]
    return yaml.safe_dump(
        {**results.study, "recordings": lines},
        sort_keys=False,
        allow_unicode=True,
        default_flow_style=None,
        width=CODE_WIDTH,
    )


def _recordings(results: Results) -> Sequence[Mapping[str, Any]]:
    recordings: Sequence[Mapping[str, Any]] = results.study["recordings"]
    return recordings


class _Line(dict[str, Any]):
    """A mapping that is written in braces."""


yaml.SafeDumper.add_representer(
    _Line, lambda dumper, line: dumper.represent_mapping("tag:yaml.org,2002:map", line, True)
)

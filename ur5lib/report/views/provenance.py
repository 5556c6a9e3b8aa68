"""Provenance of the results: code, versions, files, times, configuration."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pandas as pd
import yaml

from ur5lib.report.document import MOST_ROWS
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say

CODE_WIDTH = 110  # characters per line in the PDF


def commit(results: Results) -> Iterator[Sentence]:
    """Return the commit that made the results."""
    yield say("provenance.commit", commit=results.commit)


def versions(results: Results) -> pd.DataFrame:
    """Return the versions of the software that the numbers depend on."""
    return pd.DataFrame(results.versions.items(), columns=["package", "version"])


def errata(results: Results) -> list[str]:
    """Return each error found in the published work, with its place and the choice made here."""
    return [f"{each.place}: {each.error} Here: {each.choice}" for each in results.errata]


def total_time(results: Results) -> Iterator[Sentence]:
    """Report the time of all jobs together."""
    times: pd.DataFrame = results.tables["run_times"]
    if len(times):
        whole, start_up = times["cpu_s"].sum(), times["start_up_s"].sum()
        jobs = times["jobs"].sum()
        yield say("provenance.times", jobs=jobs, whole=whole, start_up=start_up)


def configuration_heading(results: Results) -> Iterator[Sentence]:
    """Return the sentence above the configuration."""
    cut = MOST_ROWS if _recordings(results)[MOST_ROWS:] else 0
    yield say("provenance.configuration", cut=cut)


def configuration(results: Results) -> str:
    """Return the study with every default filled in."""
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
    """A mapping that is written in braces, on one line."""


yaml.SafeDumper.add_representer(
    _Line, lambda dumper, line: dumper.represent_mapping("tag:yaml.org,2002:map", line, True)
)

"""The summary of a study, `results.json`: verdicts, what they were before, next steps, findings."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import pandas as pd
from pydantic import Field, ValidationError

from ur5lib.records.verdicts import Verdict
from ur5lib.report.found import findings, left_out
from ur5lib.report.next_steps import next_steps
from ur5lib.report.results import Results
from ur5lib.report.stated import Step
from ur5lib.strict import Strict

SCHEMA_FILE = "results.schema.json"
KEY = ("question", "arm", "quantity", "unit", "interval", "joint", "axis", "motion", "recording")
WHOLE = {"rank", "joint", "count", "of"}  # columns of integers
DIGITS = 3  # two numbers are the same if they agree in this many significant digits


@dataclass(frozen=True)
class Before:
    """The number of a verdict in the last build, where it has changed since.

    value, count, of: as in verdicts.csv; date: of that build (ISO), empty if unknown.
    """

    value: float | None = None
    count: int | None = None
    of: int | None = None
    date: str = ""


@dataclass(frozen=True, kw_only=True)
class StatedVerdict(Verdict):
    """A row of verdicts.csv; before: its number in the last build, None if that was the same."""

    before: Before | None = None


class Summary(Strict):
    """The first screen of a report as data."""

    schema_file: str = Field(alias="$schema")
    study: str
    title: str
    simulated: list[str] = Field(description="recordings of the virtual test stand")
    commit: str = Field(description="of the code")
    analysed: str = Field(description="date on which the last step ended, empty if unknown")
    verdicts: list[StatedVerdict] = Field(description="the rows of tables/verdicts.csv")
    next: list[Step] = Field(description="what to do next, the most urgent first")
    findings: list[str] = Field(description="faults and facts, the gravest first")
    left_out: list[str] = Field(description="results that the data do not allow, with the reasons")


def page_data(results: Results, last: Summary | None = None) -> dict[str, Any]:
    """Return the data of a page's first screen: verdicts, and what was found.

    last: the summary of the last build.
    """
    found = {
        "next": [*map(asdict, next_steps(results))],
        "findings": findings(results),
        "left_out": left_out(results),
    }
    return {"verdicts": verdict_rows(results, last), "found": found}


def summary(results: Results, data: Mapping[str, Any]) -> dict[str, object]:
    """Return the summary of a study from `page_data`, as plain data of `summary_schema`."""
    recordings = results.study["recordings"]
    plain = {
        "$schema": SCHEMA_FILE,
        "study": results.study["study"],
        "title": results.study["title"],
        "simulated": [entry["name"] for entry in recordings if entry.get("simulate")],
        "commit": results.commit,
        "analysed": analysed_on(results),
        "verdicts": [*map(_known, data["verdicts"])],
        **data["found"],
    }
    return Summary.model_validate(plain).model_dump(by_alias=True)


def summary_schema() -> dict[str, object]:
    """Return the JSON schema of a summary."""
    return Summary.model_json_schema(by_alias=True)


def last_summary(path: Path) -> Summary | None:
    """Return the summary of the last build, None if it is missing or from another version."""
    try:
        return Summary.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None


def analysed_on(results: Results) -> str:
    """Return the date on which the last step ended (ISO), "" if no step has a time."""
    times = results.tables.get("run_times")
    return str(times["last_end"].max())[:10] if times is not None and len(times) else ""


def verdict_rows(results: Results, last: Summary | None = None) -> list[dict[str, Any]]:
    """Return the rows of verdicts.csv as plain data, empty cells as None.

    before: the different number of the last build (value, count, of, date), None if it is the same.
    A build in which no number changed keeps `before` of the last build.
    """
    rows = [_plain(row) for row in results.rows("verdicts").to_dict("records")]
    earlier = _by_key(map(asdict, last.verdicts)) if last else {}
    same = all(_key(row) in earlier and not _differ(row, earlier[_key(row)]) for row in rows)
    date = last.analysed if last else ""
    return [row | {"before": _before(row, earlier.get(_key(row)), date, same)} for row in rows]


def _before(
    row: dict[str, Any], was: dict[str, Any] | None, date: str, same: bool
) -> dict[str, Any] | None:
    """Return the number that a row of verdicts.csv had in the last build if it was different, else
    None.

    was: the row in the last build, None without one; date: of that build; same: whether no number
    of the study changed.
    """
    if was is None:
        return None
    if same:
        return was["before"]
    return asdict(Before(*_numbers(was), date)) if _differ(row, was) else None


def _differ(row: dict[str, Any], was: dict[str, Any]) -> bool:
    """Return whether a row had a number, and a different one."""
    numbers = _numbers(was)
    return numbers != (None, None, None) and _rounded(row) != _rounded(was)


def _rounded(row: dict[str, Any]) -> tuple[str, int | None, int | None]:
    value, count, of = _numbers(row)
    return "" if value is None else f"{value:.{DIGITS}g}", count, of


def _numbers(row: dict[str, Any]) -> tuple[float | None, int | None, int | None]:
    return row["value"], row["count"], row["of"]


def _by_key(rows: Iterable[dict[str, Any]]) -> dict[tuple[str, ...], dict[str, Any]]:
    return {_key(row): row for row in rows}


def _key(row: dict[str, Any]) -> tuple[str, ...]:
    """Return what identifies a number among the rows of verdicts.csv, by which it is found in the
    last build.
    """
    return tuple(str(row[part] or "") for part in KEY)


def _plain(row: dict[Any, Any]) -> dict[str, Any]:
    """Return a row of a table with None for empty cells."""
    own: dict[str, Any] = {field.name: None for field in fields(Verdict)}  # of an earlier version
    own |= {str(name): None if pd.isna(value) else value for name, value in row.items()}
    return own | {name: int(own[name] or 0) for name in WHOLE if own[name] is not None}


def _known(row: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in row.items() if value is not None}

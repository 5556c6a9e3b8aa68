"""The data that Python gives to the page: study, rows of tables and views, as JSON in a folder."""

import csv
import json
import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

import numpy as np
import pandas as pd

from ur5lib import __version__
from ur5lib.errors import InputError, unknown
from ur5lib.force.estimators import ESTIMATES, LEADING, NEW
from ur5lib.records.verdicts import COPIED, NO_DOUBT, STATES
from ur5lib.report.figures.traces import BAND_EDGES, ERROR, HIDDEN, LINE_COLUMN, UNFILTERED
from ur5lib.report.page import closer
from ur5lib.report.results import Results
from ur5lib.report.summary import analysed_on
from ur5lib.report.views import forces
from ur5lib.strict import read_yaml
from ur5lib.workspace.places import CITATION, PACKAGE
from ur5lib.workspace.topics import modules_of_topics

SOURCES = Path(__file__).parent
TOPICS = sorted(PACKAGE.glob("topics/*/section.typ"))
WORDS = (*sorted(SOURCES.glob("*.typ")), *sorted(SOURCES.glob("*/*.typ")), *TOPICS)
ROWS = re.compile(r'rows-of\("([\w.]+)"\)')
ROW_CLASS = re.compile(r"\brows? of (\w+)\.csv")
DIGITS = 15  # of numbers in JSON, after the point
MOST_NAMED = 4  # recordings in a notice


class AbsentTableError(KeyError):
    """A table that is not among the study's tables, as one of a topic that the study does
    not have.
    """


class Tables(dict[str, pd.DataFrame]):
    """Tables by name; one that is absent raises AbsentTableError."""

    def __missing__(self, name: str) -> pd.DataFrame:
        raise AbsentTableError(name)


@contextmanager
def handed_over(results: Results, stated: Mapping[str, Any]) -> Iterator[Path]:
    """Provide a folder with the sources of the page and the data that they read.

    stated: `verdicts` and, for a page with a first screen, `found`, both as in `page_data`.
    """
    results = replace(results, tables=Tables(results.tables))
    rows = {f"rows/{name}": rows_of(name, results) for name in rows_read()}
    with sources({**study_data(results), **stated, **rows}, results.figures) as root:
        yield root


@contextmanager
def sources(data: Mapping[str, object], figures: Path = Path()) -> Iterator[Path]:
    """Provide a temporary folder with Typst's sources of the page and the data that they read;
    data: contents of the JSON files, by name; figures: folder of the figures.
    """
    with TemporaryDirectory() as folder:
        root = Path(folder)
        for main in SOURCES.glob("*.typ"):
            shutil.copy(main, root)  # a main file must not be a link
        for part in ("kit", "sections"):
            (root / part).symlink_to(SOURCES / part)
        (root / "figures").symlink_to(figures.resolve())
        (root / "topics").mkdir()
        for section in TOPICS:
            (root / "topics" / section.parent.name).symlink_to(section.parent)
        for name, content in {"supplement": [], **data}.items():
            path = root / f"data/{name}.json"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(_as_json(content), encoding="utf-8")
        (root / "data/replay.css").write_text(closer.styles(), encoding="utf-8")
        yield root


def of_no_study() -> dict[str, Any]:
    """Return the page's data for a study without recordings and rows."""
    study = {"study": "", "title": "", "recordings": []}
    tables = {
        "recordings": pd.DataFrame(columns=["recording", "duration_s"]),
        "quality": pd.DataFrame(columns=["recording", "device", "code", "finding"]),
    }
    found = {"verdicts": [], "found": {"next": [], "findings": [], "left_out": []}}
    return {
        **study_data(Results(study, tables)),
        **found,
        **{f"rows/{own}": [] for own in rows_read()},
    }


def _as_json(content: object) -> str:
    """Return rows as JSON, a dictionary each, with null for empty cells."""
    if isinstance(content, pd.DataFrame):
        rows = content.reset_index(drop=True)
        return str(rows.to_json(orient="records", double_precision=DIGITS, force_ascii=False))
    return json.dumps(content, ensure_ascii=False, default=np.generic.item)


def rows_read() -> list[str]:
    """Return the names of the tables and views that the page's sources ask for by `rows-of`."""
    return sorted({name for path in WORDS for name in ROWS.findall(path.read_text("utf-8"))})


def rows_of(name: str, results: Results) -> object:
    """Return the rows of a table, or of a view `module.function`; [] if a topic's table is absent.

    Raises KeyError or AttributeError if there is no such view, InputError if no table has the name.
    """
    module, _, function = name.rpartition(".")
    try:
        return getattr(views()[module], function)(results) if module else results.rows(name)
    except AbsentTableError as absent:
        if absent.args[0] not in tables_of_rows():
            raise InputError(unknown("table", absent.args[0], [*tables_of_rows()])) from None
        return []


@cache
def tables_of_rows() -> dict[str, Path]:
    """Return the file with the class of rows of each table, by the table's name."""
    files = [
        path for part in ("records", "steps", "topics/*") for path in PACKAGE.glob(f"{part}/*.py")
    ]
    return {name: path for path in files for name in ROW_CLASS.findall(path.read_text("utf-8"))}


@cache
def views() -> dict[str, ModuleType]:
    """Return the modules of views by name, those of topics by their folders."""
    own = (path.stem for path in PACKAGE.glob("report/views/*.py"))
    views = {name: import_module(f"ur5lib.report.views.{name}") for name in own}
    return views | modules_of_topics("report")


def study_data(results: Results) -> dict[str, Any]:
    """Return the data on the whole study that every page reads, under the key `study`."""
    study = results.study
    effort = results.effort._asdict()
    figures = dict(drawn_figures(results.figures))
    told = notice(results)
    return {
        "study": effort
        | {key.capitalize(): text.capitalize() for key, text in effort.items()}
        | {
            "name": study["study"],
            "title": f"{study['title']} (simulated)" if told else study["title"],
            "notice": told,
            "analysed": analysed_on(results),
            "minutes": float(results.tables["recordings"]["duration_s"].sum() / 60),
            "commit": results.commit,
            "version": __version__,
            "address": read_yaml(CITATION).get("repository-code", ""),
            "versions": dict(results.versions),
            "recordings": recordings(results),
            "robots": results.robots(),
            "other_arms": sorted(results.other_arms),
            "saturated": forces.saturated(results, [*results.roles()]),
            "many": results.many,
            "estimates": ESTIMATES,
            "leading": ESTIMATES[LEADING],
            "new": [*NEW],
            "states": STATES | {"no doubt": NO_DOUBT},
            "copied": COPIED,
            "figures": figures,
            "scenes": sorted({name.split("/")[0] for name in figures} & _scenes(results.figures)),
            "sections": sections(),
        }
    }


def recordings(results: Results) -> list[dict[str, str]]:
    """Return name, short name (R1, R2, …), role and arm of each recording."""
    arms, roles = results.arms(), results.roles()
    return [
        {"name": name, "short": f"R{number}", "role": role, "robot": arms[name]}
        for number, (name, role) in enumerate(roles.items(), start=results.first_number)
    ]


def sections() -> list[str]:
    """Return the paths of the sections, those of topics among them."""
    own = (f"/sections/{path.name}" for path in sorted(SOURCES.glob("sections/*.typ")))
    return [*own, *(f"/topics/{path.parent.name}/section.typ" for path in TOPICS)]


def notice(results: Results) -> str:
    """Return a notice of simulated recordings, if any."""
    entries = results.study["recordings"]
    simulated = [str(one["name"]) for one in entries if one.get("simulate") or one.get("truth")]
    if not simulated:
        return ""
    some = f"{len(simulated)} recordings" if simulated[MOST_NAMED:] else ", ".join(simulated)
    some = "all recordings" if len(simulated) == len(entries) else some
    return f"Simulated: {some} of this study are of the virtual test stand, not of a real arm."


def _scenes(figures: Path) -> set[str]:
    return {path.parent.name for path in figures.glob("*/scene.json")}


def drawn_figures(folder: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield (path without suffix, description of the content) of each figure that has numbers.

    lines, errors: labels; banded: the label with a band; pale, hidden, gaps: whether there are
    unfiltered lines, spans near a singularity, gaps of time; columns: all labels and columns of the
    numbers.
    """
    for numbers in sorted(folder.rglob("*.csv")) if folder != Path() else ():
        with numbers.open(encoding="utf-8", newline="") as rows:
            header = next(csv.reader(rows), [])
            if next(rows, "") and numbers.with_suffix(".svg").is_file():
                yield (
                    str(numbers.relative_to(folder).with_suffix("")),
                    shown(header) | {"gaps": any(line.startswith(",") for line in rows)},
                )


def shown(header: Sequence[str]) -> dict[str, Any]:
    """Return the description of a figure's content, see `drawn_figures`, from the header of its
    numbers.
    """
    labels = [*dict.fromkeys(own[1] for own in map(LINE_COLUMN.fullmatch, header) if own)]
    errors = [label.removeprefix(ERROR) for label in labels if label.startswith(ERROR)]
    lines = [one for one in labels if one not in (*BAND_EDGES, UNFILTERED) and ERROR not in one]
    return {
        "columns": [*labels, *(name for name in header if not LINE_COLUMN.fullmatch(name))],
        "lines": lines,
        "errors": errors,
        "banded": next(
            iter([*errors, *(line for line in lines if line in ESTIMATES.values())]), None
        )
        if BAND_EDGES[0] in labels
        else None,
        "pale": UNFILTERED in labels,
        "hidden": HIDDEN in header,
    }

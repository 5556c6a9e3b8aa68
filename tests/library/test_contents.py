"""The report's contents as data: what they name exists, what they show is mentioned."""

import re
from collections.abc import Iterator
from pathlib import Path

import pandas as pd
import pytest

from tests.conftest import PROJECT
from ur5lib.report.compose import MENTION, SENTENCE_END, view
from ur5lib.report.contents import Figure, Part, Repeated, Single, Tabular, Text, contents
from ur5lib.report.results import Results

TABLES_MADE = {path.stem for path in (PROJECT / "ur5lib/report/tables").glob("[!_]*.py")}
RULES = "".join(path.read_text() for path in (PROJECT / "workflow" / "rules").glob("*.smk"))


def blocks(part: Part) -> Iterator[Single]:
    for block in part.blocks:
        yield from block.blocks if isinstance(block, Repeated) else [block]


EVERY = [block for part in contents().sections for block in blocks(part)]
FIGURES = [block for block in EVERY if isinstance(block, Figure)]
TABLES = [block for block in EVERY if isinstance(block, Tabular)]


def test_every_view_exists() -> None:
    names = re.findall(
        r"(?:sentences|items|table|listing|each): ([a-z_.]+)",
        (PROJECT / "ur5lib" / "report" / "contents.yaml").read_text(),
    )
    assert len(names) > 40
    assert all(callable(view(name)) for name in names)


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.figure)
def test_every_figure_is_drawn_by_the_rule_it_names(figure: Figure) -> None:
    (rule,) = re.findall(rf"\nrule {figure.rule}:.*?(?=\nrule |\Z)", RULES, re.DOTALL)
    drawn = re.findall(r'"([a-z_]+)"', rule)
    lists = {name: re.findall(r'"([a-z_]+)"', text) for name, text in LISTS}
    drawn += [figure for name, figures in lists.items() if name in rule for figure in figures]
    assert figure.figure in drawn


LISTS = re.findall(r"^([A-Z_]+) = \[(.*?)\]", RULES, re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.table)
def test_every_table_comes_from_a_file_of_the_workflow(table: Tabular) -> None:
    if table.source:
        name = table.source.removeprefix("tables/").removesuffix(".csv")
        assert name in TABLES_MADE or f"{table.source}" in RULES or f'tables(["{name}"])' in RULES


def test_every_table_and_figure_is_mentioned() -> None:
    """So that a reader knows what to look at it for."""
    for part in contents().sections:
        texts = [block.text for block in blocks(part) if isinstance(block, Text)]
        mentioned = {name for text in texts for name in MENTION.findall(text)}
        shown = {b.table if isinstance(b, Tabular) else b.figure for b in blocks(part)
                 if isinstance(b, Tabular | Figure)}  # fmt: skip
        assert shown - mentioned == set(), part.title
        assert mentioned - shown == set(), part.title


def test_alternative_texts_say_more_than_captions() -> None:
    for figure in FIGURES:
        assert len(figure.alternative) > 40
        assert figure.alternative != figure.caption


def test_a_sentence_ends_where_the_next_begins() -> None:
    text = "Rows as in 5.6: @a shows. “Zero” is zero, e.g. 0.5. @b too."
    assert SENTENCE_END.split(text) == [
        "Rows as in 5.6:", "@a shows.", "“Zero” is zero, e.g. 0.5.", "@b too.",
    ]  # fmt: skip


def test_a_table_named_alone_is_shown_as_it_is() -> None:
    table = pd.DataFrame({"recording": ["one"], "noise_a": [0.0123456]})
    body = view("noise")(Results(study={}, tables={"noise": table}, figures=Path()))
    assert body.header == ["recording", "noise a"]
    assert [cell.text for cell in body.rows[0]] == ["one", "0.01235"]

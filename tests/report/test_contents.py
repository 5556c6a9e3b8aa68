"""The report's contents as data: what they name exists, what they show is mentioned."""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from tests.conftest import PROJECT
from ur5lib.channels import CURRENT, TORQUE
from ur5lib.report.page.compose import (
    MENTION,
    SENTENCE_END,
    VIEWS,
    _drafts,
    _filled,
    body_of,
    compose,
    view,
)
from ur5lib.report.page.document import (
    PAGES_OF_TOPICS,
    DeclaredSection,
    DeclaredTable,
    Document,
    Heading,
    Items,
    Mention,
    Paragraph,
    Picture,
    Repeated,
    TableBlock,
    contents,
)
from ur5lib.report.results import Results
from ur5lib.tidy import columns

TABLES_MADE = columns()
FILES = *PROJECT.glob("workflow/rules/*.smk"), *PROJECT.glob("ur5lib/topics/*/rules.smk")
RULES = "".join(path.read_text() for path in FILES)
PAGE = PROJECT / "ur5lib" / "report" / "page"
WRITTEN = [PAGE / "contents.yaml", PAGE / "sentences.yaml", *PAGES_OF_TOPICS]


EVERY = [*contents().blocks()]
FIGURES = [block for block in EVERY if isinstance(block, Picture)]
TABLES = [block for block in EVERY if isinstance(block, DeclaredTable)]


def test_every_view_exists() -> None:
    names = re.findall(
        r"(?:sentences|entries|rows|listing|judged|each): ([a-z_.]+)",
        "".join(path.read_text() for path in WRITTEN),
    )
    assert len(names) > 40
    found = [view(name) if "." in name else getattr(Results, name) for name in names]
    assert all(map(callable, found))


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.figure)
def test_every_figure_is_drawn_by_the_rule_it_names(figure: Picture) -> None:
    (rule,) = re.findall(rf"\n *rule {figure.rule}:.*?(?=\n *rule |\Z)", RULES, re.DOTALL)
    assert f'drawn_by("{figure.rule}"' in rule or f'["{figure.figure}"]' in rule


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.table)
def test_every_table_comes_from_a_file_of_the_workflow(table: DeclaredTable) -> None:
    name = table.results
    part = re.search(rf'(result|parameter)\("{name}\.csv"\)', RULES)
    made = (
        name in TABLES_MADE
        or part
        or f'    "{name}",' in RULES
        or f'tables(["{name}"' in RULES
        or f"{name}.csv" in RULES
    )
    assert made or table.rows.startswith("recordings.")


def test_every_table_and_figure_of_the_report_is_mentioned() -> None:
    """So that a reader knows what to look at it for; those of the details have captions alone."""
    details = contents().details()
    for part in [*contents().report(), *details]:
        flat = [
            b for one in part.blocks for b in (one.blocks if isinstance(one, Repeated) else [one])
        ]
        texts = [block.text for block in flat if isinstance(block, Paragraph)]
        mentioned = {name for text in texts for name in MENTION.findall(text)}
        shown = {b.table if isinstance(b, DeclaredTable) else b.figure for b in flat
                 if isinstance(b, DeclaredTable | Picture)}  # fmt: skip
        assert shown - mentioned == set() or part in details, part.title
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


FIRST = {"title": "First", "blocks": [{"table": "noise", "caption": "One."}]}
SAME = "It is in @noise. Bands{thesis| (2.64)} are wide."
SECOND = {
    "title": "Second",
    "blocks": [
        {"text": SAME},
        {"table": "noise", "caption": "One."},
        {"table": "jitter", "caption": "Two."},
    ],
}


def composed(**study: str) -> Document:
    names = {
        "study": "s",
        "title": "t",
        "recordings": [{"name": "one", "robot": "ur5", "role": "fit"}],
    }
    table = pd.DataFrame({"recording": ["one"], "duration_s": [60.0]})
    tables = dict.fromkeys(("noise", "jitter", "recordings"), table)
    parts = [DeclaredSection.model_validate(part) for part in (FIRST, SECOND)]
    return compose(parts, Results(study=names | study, tables=tables, figures=Path()))


def test_what_the_first_section_shows_is_mentioned_and_not_repeated() -> None:
    document = composed()
    assert [block.label for block in document.blocks() if isinstance(block, TableBlock)] == [
        "noise",
        "jitter",
    ]
    mention = next(block for block in document.blocks() if isinstance(block, Paragraph)).spans[1]
    assert mention == Mention("noise", "Table 1")
    assert document.subtitle == "Study “s” of ur5, recordings: 1 (1 fit; 1.0 min)"


def test_remarks_of_the_thesis_stand_in_its_report_alone() -> None:
    def said(document: Document) -> str:
        return "".join(
            map(str, next(b for b in document.blocks() if isinstance(b, Paragraph)).spans)
        )

    assert said(composed()).endswith("Bands are wide.")
    assert said(composed(reference="printed.yaml")).endswith("Bands (2.64) are wide.")


def test_a_table_named_alone_is_shown_as_it_is() -> None:
    table = pd.DataFrame({"recording": ["one"], "noise_a": [0.0123456]})
    declared = DeclaredTable("noise", "One.")
    body = body_of(declared, Results(study={}, tables={"noise": table}, figures=Path()))
    assert body.header == ["recording", "noise a"]
    assert [cell.text for cell in body.rows[0]] == ["one", "0.01235"]


@pytest.mark.parametrize("count", [0, 2])
def test_a_list_is_introduced_where_it_has_items(count: int) -> None:
    part = DeclaredSection(title="Cited", blocks=[Items(entries="some.found", above="Found:")])
    results = Results(study={}, tables={}, figures=Path())
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(VIEWS, "some", SimpleNamespace(found=lambda _: ["One."] * count))
        shown = [*_drafts(part, results)]
    assert [type(block) for block in shown] == ([Paragraph, Items] if count else [])


@pytest.mark.parametrize("arm", ["ur5", "ur10e"])
def test_an_arm_is_a_heading_where_a_table_of_it_is_shown(arm: str) -> None:
    table = pd.DataFrame({"robot": ["ur5"], "value": [1.0]})
    own = DeclaredTable("some", "One.", where="robot == @of")
    each = Repeated(each="robots", heading="{of}", blocks=[Paragraph(text="Of {of}."), own])
    part = DeclaredSection(title="Arms", blocks=[each])
    study = {"recordings": [{"name": "one", "robot": arm, "role": "fit"}]}
    shown = [type(block) for block in _drafts(part, Results(study, {"some": table}, Path()))]
    assert (shown[0] is Heading) == (TableBlock in shown) == (arm == "ur5")


def test_arms_that_sense_torque_have_no_currents() -> None:
    """Texts, headers and units say torque and Nm; what a user named keeps its currents."""
    rows = pd.DataFrame({"recording": ["current-2"], "duration_s": [60.0], "current": [0.3]})
    part = {
        "title": "{Quantity}s",
        "blocks": [
            {"text": "@noise has the {quantity}s."},
            {"table": "noise", "caption": "Errors [{unit}].",
             "columns": {"run": "recording", "{quantity} [{unit}]": "current"}},
            {"sentences": "recordings.commit"},
        ],
    }  # fmt: skip
    parts = [DeclaredSection.model_validate({"title": "First", "blocks": []} | one)
             for one in ({}, part)]  # fmt: skip
    study = {"study": "s", "title": "No {quantity} of A", "recordings": [
        {"name": "current-2", "robot": "ur5", "role": "fit"}]}  # fmt: skip
    tables = {"noise": rows, "recordings": rows}
    results = Results(
        study=study, tables=tables, figures=Path(), commit="{quantity}", effort=TORQUE
    )
    document = compose(parts, results)
    (section,) = document.sections
    text, table, made = section.blocks
    assert (section.title, document.title) == ("Torques", "No {quantity} of A")
    assert isinstance(text, Paragraph)
    assert isinstance(table, TableBlock)
    assert isinstance(made, Paragraph)
    assert (text.spans[-1], made.spans) == (" has the torques.", ["Made by commit {quantity}."])
    assert (table.caption, table.header) == ("Errors [Nm].", ["run", "torque [Nm]"])
    assert [cell.text for cell in table.rows[0]] == ["current-2", "0.3"]
    (currents,) = compose(parts, replace(results, effort=CURRENT)).sections
    assert currents.title == "Currents"


def test_every_word_in_braces_has_a_meaning() -> None:
    for file in WRITTEN:
        braces = re.findall(r"(?<![{%])\{(\w+)\}(?!\})", file.read_text())
        words = [*CURRENT._asdict(), *map(str.capitalize, CURRENT._asdict())]
        assert {*braces} <= {"of", "leading", "drawn", *words}, file


@pytest.mark.parametrize(("other", "said"), [(False, "of ur5, upright"), (True, "of ur5, at zero")])
def test_captions_know_the_arm(other: bool, said: str) -> None:
    arms = frozenset({"ur5"} if other else ())
    results = Results({"recordings": []}, {}, Path(), other_arms=arms)
    assert _filled("of {of}, {ur|upright}{other|at zero}", results, "ur5") == said

"""What the cards of a report showed when the study was last built, next to what they show now."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from pydantic import ValidationError

from ur5lib.report.page.document import Card, Cards, Document, Number, Section
from ur5lib.report.page.formats import day
from ur5lib.report.page.summary import Summary
from ur5lib.report.views.cards import number


def last_summary(path: Path) -> Summary | None:
    """Return the summary of the last build, None where there is none that this version reads."""
    try:
        return Summary.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None


def beside_last(document: Document, last: Summary | None) -> Document:
    """Return a report whose cards state what their numbers were in the last build, if others.

    A build that shows the same numbers on all cards states what the last one does.
    """
    if last is None:
        return document
    rows = [
        {name: value for name, value in vars(row).items() if value not in (None, "")}
        for row in last.verdicts
    ]
    earlier = {own.key: own for own in map(number, rows)}
    first, *others = document.sections
    shown = [one for card in _cards(first) for one in card.numbers]
    same = all(one.key in earlier and earlier[one.key].text == one.text for one in shown)
    date = f", {day(last.analysed)}" if last.analysed else ""

    def beside(one: Number) -> Number:
        was = earlier.get(one.key, one)
        changed = f"{was.text}{date}" if was.text != one.text else ""
        return replace(one, before=was.before if same else changed)

    blocks = [
        replace(block, cards=[_with_numbers(card, beside) for card in block.cards])
        if isinstance(block, Cards)
        else block
        for block in first.blocks
    ]
    return replace(document, sections=[replace(first, blocks=blocks), *others])


def _cards(section: Section) -> Iterator[Card]:
    for block in section.blocks:
        yield from block.cards if isinstance(block, Cards) else ()


def _with_numbers(card: Card, changed: Callable[[Number], Number]) -> Card:
    return replace(card, numbers=tuple(map(changed, card.numbers)))

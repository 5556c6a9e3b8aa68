"""What the cards of a report showed when the study was last built, beside what they show now."""

from dataclasses import replace
from pathlib import Path

from pydantic import ValidationError

from ur5lib.report.page.document import Document, Number, Verdict, Verdicts
from ur5lib.report.page.formats import day
from ur5lib.report.page.summary import Summary, VerdictSummary


def last_summary(path: Path) -> Summary | None:
    """Return the summary of the last build, None where there is none that this version reads."""
    try:
        return Summary.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None


def beside_last(document: Document, last: Summary | None) -> Document:
    """Return a report whose cards state what their first number was in the last build, if another.

    A build that shows the same numbers on all cards states what the last one does.
    """
    if last is None:
        return document
    first, *others = document.sections
    blocks = [
        _beside(block, last) if isinstance(block, Verdicts) else block for block in first.blocks
    ]
    return replace(document, sections=[replace(first, blocks=blocks), *others])


def _beside(cards: Verdicts, last: Summary) -> Verdicts:
    known = {card.topic: card for card in last.verdicts}
    same = [*map(_shown, cards.verdicts)] == [*map(_shown, last.verdicts)]
    found = []
    for card in cards.verdicts:
        earlier = known[card.topic].numbers[:1] if card.topic in known else []
        numbers = [
            replace(now, before=was.before if same else _before(now, was, last.analysed))
            for now, was in zip(card.numbers, earlier, strict=False)
        ]
        found.append(replace(card, numbers=(*numbers, *card.numbers[len(numbers) :])))
    return replace(cards, verdicts=found)


def _shown(card: Verdict | VerdictSummary) -> tuple[str, list[tuple[str, str, str]]]:
    return card.topic, [(one.name, one.place, one.text()) for one in card.numbers]


def _before(now: Number, was: Number, analysed: str) -> str:
    """Return the text of a number in the last build and its date, empty where it is the same or of
    something else.
    """
    alike = all(
        getattr(now, name) == getattr(was, name) for name in ("name", "unit", "place", "interval")
    )
    date = f", {day(analysed)}" if analysed else ""
    return f"{was.text()}{date}" if alike and was.text() != now.text() else ""

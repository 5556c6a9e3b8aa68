"""What import states about a file, gathered into one row for each of its columns."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import get_args

from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.evidence import SOURCES, Row
from ur5lib.records.account import NOTHING, AccountRow, Confidence, Evidence

Names = tuple[str, ...]  # of a block's columns
REASONS = {"option": "as stated", "name": "named so", "position": "by its place", "numbers": ""}
WEIGHT: tuple[Confidence, ...] = get_args(Confidence)  # of a block's statements, the first counts


@dataclass(frozen=True)
class Account:
    """What import states about a file: rows on blocks of columns, and on the file as a whole.

    order: the file's columns in order; of_columns: rows by the names of a block's columns; of_file:
    in order; excluded: column names of the blocks that the entry lacks; evidence: what each source
    says of a block, from which its verdict follows.
    """

    order: list[str] = field(default_factory=list)
    of_columns: dict[Names, list[AccountRow]] = field(default_factory=dict)
    of_file: list[AccountRow] = field(default_factory=list)
    excluded: list[Names] = field(default_factory=list)
    evidence: list[AccountRow] = field(default_factory=list)

    def tell(
        self, confidence: Confidence, subject: str, taken_for: str, by: Evidence, reason: str
    ) -> None:
        """State something about the file as a whole."""
        row = AccountRow(subject, taken_for, by, confidence, reason)
        if row not in self.of_file:
            self.of_file.append(row)

    def state(
        self, confidence: Confidence, names: Names, title: str, by: Evidence, reason: str
    ) -> None:
        """State what columns contain, or why they are left out; title: their names in short."""
        row = AccountRow(title, "", by, confidence, reason)
        told = self.of_columns.setdefault(names, [])
        if row not in told:
            told.append(row)

    def hold(self, confidence: Confidence, block: ColumnBlock, by: Evidence, reason: str) -> None:
        """State what a block contains, and how sure that is."""
        self.state(confidence, block.names, block.title, by, reason)

    def speak(self, block: ColumnBlock, rows: Iterable[Row], candidates: Mapping[str, str]) -> None:
        """State what sources say of a block; candidates: with their words."""
        for row in rows:
            words = f"{row.source}: {row.words()}" if row.code else row.source
            by = SOURCES[row.source].by
            figures = row.in_figures(candidates)
            self.evidence.append(AccountRow(block.title, figures, by, "evidence", words))

    def prove(self, block: ColumnBlock, reason: str) -> None:
        """State what the numbers prove of a block; the rows that ask to check it are removed."""
        told = self.of_columns.get(block.names, [])
        told[:] = [row for row in told if row.confidence != "check"]
        self.hold("proven", block, "numbers", reason)

    def exclude(self, block: ColumnBlock, reason: str, by: Evidence = "numbers") -> None:
        """Leave a block out of the entry."""
        self.excluded.append(block.names)
        self.hold("left out", block, by, reason)

    def rows(self, meanings: Mapping[Names, str]) -> list[AccountRow]:
        """Return a row for each block of columns, below those of the file as a whole.

        meanings: channel and unit of the blocks that the entry has, by the names of their columns.
        """
        place = {name: k for k, name in enumerate(self.order)}
        ordered = sorted(self.of_columns, key=lambda names: place.get(names[0], len(place)))
        joined = (_joined(self.of_columns[names], meanings.get(names, "")) for names in ordered)
        return [*self.of_file, *_merged(joined), *self.evidence]


def _joined(told: Sequence[AccountRow], meaning: str) -> AccountRow:
    """Return the one row of all statements on a block; without a `meaning`, it gives why the block
    is left out.
    """
    kept = [row for row in told if meaning or row.confidence == "left out"] or [*told]
    ordered = sorted(kept, key=lambda row: WEIGHT.index(row.confidence))
    return AccountRow(
        ordered[0].subject,
        meaning or NOTHING,
        ordered[0].evidence,
        ordered[0].confidence if meaning else "left out",
        "; ".join(row.reason for row in ordered if row.reason) or REASONS[ordered[0].evidence],
    )


def _merged(rows: Iterable[AccountRow]) -> Iterator[AccountRow]:
    """Yield the rows; those with the same meaning and subject, or left out for the same reason, as
    one.
    """
    alike = dict[tuple[str, str], list[AccountRow]]()
    for row in rows:
        key = row.reason if row.taken_for == NOTHING else row.subject
        alike.setdefault((row.taken_for, key), []).append(row)
    for same in alike.values():
        yield replace(same[0], subject=", ".join(row.subject for row in same))

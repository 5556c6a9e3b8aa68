"""The results of a study's recordings and arms, read as the tables need them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ur5lib.report.reference import Printed
from ur5lib.tables import read_json

Row = dict[str, object]


@dataclass(frozen=True)
class StudyResults:
    """Paths of results by their kind; each lies in the folder of its recording or arm.

    printed: published tables that are compared with.
    """

    paths: Mapping[str, Sequence[str]]
    printed: Printed = Printed()

    def each(self, kind: str) -> Iterator[tuple[str, Any]]:
        """Yield each recording's or arm's name and its summary of this kind."""
        for name, path in self.paths_of(kind).items():
            yield name, read_json(path)

    def all(self, kind: str) -> dict[str, Any]:
        """Return the summaries of this kind by recording or arm."""
        return dict(self.each(kind))

    def paths_of(self, kind: str) -> dict[str, str]:
        """Return the paths of this kind by recording or arm."""
        return {Path(path).parent.name: path for path in self.paths[kind]}

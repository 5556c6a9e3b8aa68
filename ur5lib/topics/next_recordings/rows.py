"""The value of another recording of an arm."""

from dataclasses import dataclass

from ur5lib.excitation.outlook import Bands


@dataclass(frozen=True)
class RankedBands(Bands):
    """A row of next_recordings.csv: bands after another recording; worthwhile: whether that narrows
    the band of a force by a tenth or more (yes, no).
    """

    worthwhile: str = "no"

"""How well currents are predicted, and what the arm carried by these."""

from dataclasses import dataclass, field

from ur5lib.identification.payload import JudgedLoad
from ur5lib.identification.validation import Scores


@dataclass(frozen=True)
class Prediction:
    """currents.json: how well the currents of a recording are predicted, and what the arm carried.

    fitted: whether it is a recording of the fit; scores: by model.
    """

    fitted: bool
    scores: dict[str, Scores] = field(default_factory=dict)
    load: JudgedLoad | None = None

    @property
    def is_loaded(self) -> bool:
        """Return whether the prediction includes an undeclared load."""
        return self.load is not None and self.load.taken

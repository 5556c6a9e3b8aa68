"""What a recording's torques and forces rest on."""

from dataclasses import dataclass

from ur5lib.records.carried import Carried
from ur5lib.records.quality import Contradictions


@dataclass(frozen=True)
class Premises:
    """premises.json: the payload that the arm carries, and what contradicts the study."""

    load: Carried
    contradictions: Contradictions

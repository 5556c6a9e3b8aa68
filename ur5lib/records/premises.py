"""What a recording's torques and forces rest on."""

from dataclasses import dataclass, field

from ur5lib.records.carried import Carried
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.quality import Contradictions


@dataclass(frozen=True)
class Premises:
    """premises.json: the payload that the arm carries, what contradicts the study, and where
    contacts are assumed.
    """

    load: Carried
    contradictions: Contradictions
    place: ContactPlace = field(default_factory=ContactPlace)

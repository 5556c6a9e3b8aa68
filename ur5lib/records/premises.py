"""The premises of a recording's torques and forces."""

from dataclasses import dataclass, field

from ur5lib.records.carried import Carried
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.quality import Contradictions


@dataclass(frozen=True)
class Premises:
    """premises.json: what a recording's torques and forces rest on: the arm's payload,
    contradictions of the study, and the assumed place of contacts.
    """

    load: Carried
    contradictions: Contradictions
    place: ContactPlace = field(default_factory=ContactPlace)

"""The premises of a recording's torques and forces."""

from dataclasses import dataclass, field

from ur5lib.records.carried import Carried
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.quality import Contradictions

MARGIN = 0.5  # s; the low-pass spreads a contact this far


@dataclass(frozen=True)
class Premises:
    """premises.json: what a recording's torques and forces rest on: the arm's payload,
    contradictions of the study, the assumed place of contacts, and from and to [s] of contacts
    that check finds in a recording to fit on.
    """

    load: Carried
    contradictions: Contradictions
    place: ContactPlace = field(default_factory=ContactPlace)
    touched: list[tuple[float, float]] = field(default_factory=list)

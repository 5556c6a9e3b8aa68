"""Verdicts against an export, and the reason that overrules them, which is put in the file."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ur5lib.commands.verdicts import CardState, card_states
from ur5lib.errors import InputError, printable
from ur5lib.finished import StudyFiles, no_verdicts
from ur5lib.records.verdicts import reason_in_words

FORBIDDEN = "do not use"


@dataclass(frozen=True)
class Overruled:
    """The verdicts against an export that the user overruled, as sentences, and the given reason.

    verdicts: empty if none is against the export.
    """

    reason: str = ""
    verdicts: tuple[str, ...] = ()

    def in_json(self) -> dict[str, Any]:
        """Return the reason and the verdicts as a field for a JSON file, {} if nothing was
        overruled.
        """
        return {"accepted": asdict(self)} if self.verdicts else {}

    def as_comment(self, in_xml: bool) -> str:
        """Return the reason and the verdicts as a comment, the first line of an XML or a YAML file;
        "" if nothing was overruled.
        """
        if not self.verdicts:
            return ""
        note = f"The study says: {' '.join(self.verdicts)} Exported nevertheless: {self.reason}"
        # a comment of XML may not contain two hyphens in a row
        return f"<!-- {re.sub('-(?=-)', '- ', note)} -->\n" if in_xml else f"# {note}\n"


def overruled(study: StudyFiles, robot: str, questions: Sequence[str], reason: str) -> Overruled:
    """Return the verdicts against an export of an arm, overruled by a reason.

    questions: those of verdicts.csv that concern the export; reason: "" for none. Raises InputError
    if no reason is given, and a verdict says not to use it or the results have no verdicts.
    """
    stated, states = " ".join(printable(reason).split()), card_states(study.folder)
    if states is None:
        verdicts, refusal = [reason_in_words("not_run")], no_verdicts(study.folder)
    else:
        verdicts = [*_against(states, robot, questions)]
        refusal = f"{study.folder}: {' '.join(verdicts)}".removesuffix(".")
    if verdicts and not stated:
        raise InputError(
            f'{refusal}; to export {robot} nevertheless, say why: --accept "<reason>", which the '
            "file then states"
        )
    return Overruled(stated if verdicts else "", tuple(verdicts))


def _against(states: Sequence[CardState], robot: str, questions: Sequence[str]) -> Iterator[str]:
    """Yield the verdicts that say "do not use", those on the arm, else those on all arms."""
    for question in questions:
        own = [one for one in states if one.question == question and one.arm in ("", robot)]
        if own and (decides := max(own, key=lambda one: bool(one.arm))).state == FORBIDDEN:
            yield f"{decides.line().removesuffix('.')}."

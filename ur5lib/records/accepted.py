"""Stop signs of the kinds that the study accepts become warnings with the study's reasons."""

from collections.abc import Container, Iterable, Iterator, Mapping

from ur5lib.records.codes import Found
from ur5lib.records.quality import Contradictions, Finding


def up_to_first_standing(signs: Iterable[Finding], accepted: Container[str]) -> Iterator[Finding]:
    """Yield stop signs up to the first that the study does not accept; later ones follow from that
    one.
    """
    for sign in signs:
        yield sign
        if sign.kind not in accepted:
            return


def accepting(found: Contradictions, accepted: Mapping[str, str]) -> Contradictions:
    """Return contradictions with accepted stop signs as warnings, and notes on unused reasons.

    accepted: the study's reasons by kind.
    """
    kinds = {sign.kind for sign in found.stop_signs}
    standing = [sign for sign in found.stop_signs if sign.kind not in accepted]
    overruled = [sign for sign in found.stop_signs if sign not in standing]
    told = (accepted_sign(sign.detail, accepted[sign.kind]) for sign in overruled)
    findings = [Finding("robot", Found.ACCEPTED_STOP_SIGN, "warning", 1, one) for one in told]
    if needless := [kind for kind in accepted if kind not in kinds]:
        named = " and ".join(needless)
        detail = f"`accept` names {named}, which nothing in this recording contradicts"
        findings.append(Finding("robot", Found.NEEDLESS_REASON, "note", len(needless), detail))
    return Contradictions(standing, [*findings, *found.findings])


def accepted_sign(sign: str, reason: str) -> str:
    """Return the sentence of an accepted stop sign, with the study's reason."""
    return f"accepted by the study: {reason}; found: {sign}"

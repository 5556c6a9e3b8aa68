"""Stop signs that the study accepts by their kind: they become warnings with its reasons."""

from collections.abc import Container, Iterable, Iterator, Mapping

from ur5lib.records.quality import Contradictions, Finding, kind_of

ACCEPTED = "accepted stop sign"  # the finding that the study overrules a stop sign


def up_to_first_standing(signs: Iterable[Finding], accepted: Container[str]) -> Iterator[Finding]:
    """Yield stop signs up to the first of a kind that is not accepted: others follow from it."""
    for sign in signs:
        yield sign
        if kind_of(sign) not in accepted:
            return


def accepting(found: Contradictions, accepted: Mapping[str, str]) -> Contradictions:
    """Return contradictions whose accepted stop signs are warnings, and notes on needless reasons.

    accepted: the study's reasons by kind.
    """
    kinds = {kind_of(sign) for sign in found.stop_signs}
    standing = [sign for sign in found.stop_signs if kind_of(sign) not in accepted]
    overruled = (sign for sign in found.stop_signs if sign not in standing)
    findings = [_warning(sign, accepted[kind_of(sign)]) for sign in overruled]
    needless = [kind for kind in accepted if kind not in kinds]
    if needless:
        values = {"kinds": needless}
        findings.append(Finding("robot", "needless reason", "note", len(needless), values))
    return Contradictions(standing, [*findings, *found.findings])


def _warning(sign: Finding, reason: str) -> Finding:
    shown = {"code": sign.code, "values": sign.values}
    return Finding("robot", ACCEPTED, "warning", 1, {"reason": reason, "found": shown})

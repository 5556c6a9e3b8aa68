"""Stop signs by kind, and those that the study accepts: they become warnings with its reasons."""

from collections.abc import Container, Iterable, Iterator, Mapping

from ur5lib.records.quality import Contradictions, Finding

ACCEPTED = "accepted stop sign"  # the finding that the study overrules a stop sign
CODES = {  # of contradictions, by the kind under which a study accepts them
    "constants": [
        "contradicting constants",
        "contradicting gains",
        "foreign constant",
        "foreign constant of known cause",
    ],
    "delay": ["early current", "late current"],
    "mounting": ["other mounting", "other mounting or sign"],
    "order": [
        "exchanged currents",
        "exchanged joints",
        "exchanged joints at rest",
    ],
    "payload": ["undeclared load"],
    "rectified": ["rectified efforts"],
    "robot": [
        "gravity unexplained",
        "other arm's currents",
        "other arm's currents at rest",
        "other torque",
        "other torque of known cause",
        "tool off flange",
    ],
    "sampling": ["untold motion"],
    "side": ["unknown side"],
    "sign": [
        "opposite current",
        "turned current",
        "turned current at rest",
        "turned current by links",
        "turned torques",
        "turned torques by links",
    ],
    "targets": ["exchanged channels", "simulated"],
    "torques": ["constant torques"],
    "unit": [
        "current in mA",
        "current not in mA",
        "foreign size",
        "foreign size of links",
        "no current",
        "scaled current",
        "torque as current",
    ],
    "velocity": ["no velocity"],
}
KINDS = {code: kind for kind, codes in CODES.items() for code in codes}


def up_to_first_standing(signs: Iterable[Finding], accepted: Container[str]) -> Iterator[Finding]:
    """Yield stop signs up to the first of a kind that is not accepted: others follow from it."""
    for sign in signs:
        yield sign
        if KINDS.get(sign.code) not in accepted:
            return


def accepting(found: Contradictions, accepted: Mapping[str, str]) -> Contradictions:
    """Return contradictions whose accepted stop signs are warnings, and notes on needless reasons.

    accepted: the study's reasons by kind.
    """
    kinds = {KINDS.get(sign.code, "") for sign in found.stop_signs}
    standing = [sign for sign in found.stop_signs if KINDS.get(sign.code) not in accepted]
    overruled = (sign for sign in found.stop_signs if sign not in standing)
    findings = [_warning(sign, accepted[KINDS[sign.code]]) for sign in overruled]
    needless = [kind for kind in accepted if kind not in kinds]
    if needless:
        values = {"kinds": needless}
        findings.append(Finding("robot", "needless reason", "note", len(needless), values))
    return Contradictions(standing, [*findings, *found.findings])


def _warning(sign: Finding, reason: str) -> Finding:
    shown = {"code": sign.code, "values": sign.values}
    return Finding("robot", ACCEPTED, "warning", 1, {"reason": reason, "found": shown})

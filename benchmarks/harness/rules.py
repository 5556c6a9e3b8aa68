"""The tables of docs/report.md on when a result is good, with limits and words of the code."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from benchmarks.harness.markdown import markdown, replaced
from ur5lib.importing.evidence import SOURCES
from ur5lib.judging import limits
from ur5lib.judging.constants import REASONS_BY_GRAVITY
from ur5lib.records.verdicts import REASONS, STATES, Reason, State, reason_in_words
from ur5lib.robots.description import LOAD_SHARE
from ur5lib.topics.health.changes import MIN_DATES

WORDS = Path(__file__).parents[2] / "ur5lib/report/page/kit/words.typ"
ERRORS = "currents, links, motion"  # questions with an error of each joint or component
RIVALLED = "currents, motion, force, bands"  # questions with a simple rival
NOTHING: list[Reason] = ["uncalibrated", "touched", "loaded", "no_motion", "no_unseen"]
NOTHING += ["no_reference", "no_sensor", "no_contact", "unknown_links"]


class Rule(NamedTuple):
    """The condition for a state of some questions' cards, and the reasons that they give."""

    state: State
    questions: str
    when: str
    reasons: Sequence[Reason]


def percent(share: float) -> str:
    """Return a share as the page writes it."""
    return f"{share:.0%}".replace("%", " %")


HALF = percent(1 - limits.MIN_GOOD_SKILL)
NO_ERROR, NO_TORQUE = limits.MIN_DIFFERENCE, limits.MIN_LINK_TORQUE
OTHER_CONSTANTS = [one for one in REASONS_BY_GRAVITY if one not in ("unlikely", "touched")]
RULES = [
    Rule("do not use", "recordings, constants, force", "a stop sign", ["stopped"]),
    Rule("do not use", f"{ERRORS}, force, bands", "error ≥ that of zero", ["worse_than_zero"]),
    Rule(
        "do not use",
        "force",
        f"the 95 % bands contain < {percent(limits.MIN_USABLE_COVERAGE)} of the readings, mean",
        ["undercovers"],
    ),
    Rule("do not use", "recordings", "none serves a purpose", ["no_effort", "no_reference"]),
    Rule("do not use", "constants", "a joint has this reason", ["unlikely", "touched"]),
    Rule("not determined", f"{ERRORS}, force", "nothing to judge by", NOTHING),
    Rule(
        "not determined",
        ERRORS,
        f"zero errs by ≤ {NO_ERROR:.5f} of its unit (links: {NO_TORQUE:g} Nm)",
        ["too_small"],
    ),
    Rule("not determined", "force, bands", "on all recordings", ["sensor_bias"]),
    Rule(
        "not determined",
        "constants",
        "that of no joint may be used",
        OTHER_CONSTANTS,
    ),
    Rule("not determined", "drift", f"dates that repeat a path < {MIN_DATES}", ["few_dates"]),
    Rule("usable", "recordings", "the gravest finding", ["unread", "error", "warning"]),
    Rule("usable", "constants", "a joint has this reason", OTHER_CONSTANTS),
    Rule("usable", "links", "judged on recordings of the fit", ["no_unseen"]),
    Rule("usable", "force", "without a fit", ["uncalibrated"]),
    Rule(
        "usable",
        "currents, force, bands",
        f"a 95 % band contains < {percent(limits.MIN_GOOD_COVERAGE)} of the readings",
        ["undercovers"],
    ),
    Rule(
        "usable",
        RIVALLED,
        f"the simple method's error < {percent(limits.BETTER_RIVAL_RATIO)} of this one",
        ["rival_better"],
    ),
    Rule(
        "usable",
        RIVALLED,
        f"error ≥ {percent(limits.BETTER_RIVAL_RATIO)} of the simple method's",
        ["rival_equal"],
    ),
    Rule(
        "usable",
        f"{ERRORS}, force",
        f"error on repeated motions > {limits.MAX_GOOD_FLOORS:g} times the repeatability",
        ["far_above_floor"],
    ),
    Rule(
        "usable",
        f"{ERRORS}, force",
        f"error ≥ {HALF} of that of zero (links: {percent(1 - limits.MIN_LINK_SKILL)})",
        ["large_error"],
    ),
    Rule(
        "usable",
        "currents",
        f"< {percent(limits.MIN_GOOD_BAND_FACTOR)} of the width of its band contains 95 %",
        ["too_wide"],
    ),
    Rule(
        "usable",
        "force",
        f"the band contains zero on > {percent(limits.MAX_BLIND_SHARE)} of the time in contact",
        ["blind"],
    ),
    Rule(
        "usable",
        "force",
        f"the 95 % interval of the error reaches {HALF} of the force",
        ["wide_interval"],
    ),
    Rule("usable", "links", "the controller counts with a load", ["loaded"]),
    Rule("usable", "load", "an undeclared load of more than chance", ["loaded", "disagrees"]),
    Rule(
        "not determined",
        "load",
        f"its 95 % interval is ± {percent(limits.MAX_LOAD_ERROR * LOAD_SHARE)} of the rated one or "
        "wider",
        ["load_unsure"],
    ),
    Rule("usable", "drift", "between dates", ["changed"]),
    Rule("good", "all", "none of these", []),
]


def with_rules(page: str) -> str:
    """Return the report's page with its rules and reasons as the code has them."""
    rows = [[STATES[one.state], one.questions, one.when, codes(one.reasons)] for one in RULES]
    rules = markdown(["state", "questions", "when", "reason"], rows)
    short = short_words()
    meant = [[f"`{code}`", short[code], reason_in_words(code)] for code in REASONS]
    reasons = markdown(["reason", "on the page", "what it means"], meant)
    return replaced(replaced(page, "When a result is good", rules), "Reasons", reasons)


def with_evidence(page: str) -> str:
    """Return the recordings' page with the sources of evidence as the code has them."""
    ordered = sorted(SOURCES.items(), key=lambda one: -one[1].cap)
    habit = {True: "yes", False: "no, habit"}
    rows = [[name, f"{own.cap:g}", own.says, habit[own.telling]] for name, own in ordered]
    return replaced(page, "Evidence", markdown(["source", "cap", "says", "is enough"], rows))


def codes(reasons: Sequence[Reason]) -> str:
    """Return codes as Markdown."""
    return ", ".join(f"`{one}`" for one in reasons)


def short_words() -> dict[str, str]:
    """Return the page's short words for each reason, for an arm with currents."""
    block = WORDS.read_text().partition("#let why = (")[2].partition("\n)")[0]
    block = block.replace('study.quantity + "', '"current')
    return dict(re.findall(r'(\w+): "([^"]*)"', block))

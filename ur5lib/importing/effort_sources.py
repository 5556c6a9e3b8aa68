"""What speaks for the unit of an effort, and whether gravity is in it: each source a function."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ur5lib.channels import CHANNELS, MEASURED_CURRENT, TARGET_CURRENT, TORQUE
from ur5lib.checks.arm import MAX_CONSTANT_RATIO, torque_constants
from ur5lib.checks.block_means import SMALLEST_SIZE, BlockMeans
from ur5lib.checks.readings import (
    CLEAR_LEAD,
    OWN_FACTORS,
    unit_scores,
)
from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.evidence import Row
from ur5lib.importing.identity import MAX_SHOWN_RATIO
from ur5lib.importing.spellings import named_unit, names_share
from ur5lib.recordings.intake import MOTOR_TORQUE
from ur5lib.recordings.less_gravity import MAX_BESIDE_MOTION, TORQUE_LESS_GRAVITY
from ur5lib.records.account import Confidence
from ur5lib.robots.description import Robot
from ur5lib.timeseries.metrics import correlation

LESS_GRAVITY, UNKNOWN, NO_EFFORT = "neither", "unknown", "no effort"
CANDIDATES = {  # and their words; a factor a joint: a share of a rating, counts, motors' side
    "A": "A",
    "mA": "mA",
    "Nm": "Nm",
    LESS_GRAVITY: "Nm, less gravity",
    UNKNOWN: "a factor a joint",
    NO_EFFORT: "no effort",
}
UNITS = ("A", "mA", "Nm")
NEWTON_METRES = (MOTOR_TORQUE, "actual_torque")
NAME_ODDS = {  # of a bare name, by its meaning
    MEASURED_CURRENT: {"A": 7.0, "mA": 5.0, UNKNOWN: 4.0},
    TARGET_CURRENT: {"A": 7.0, "mA": 5.0, UNKNOWN: 4.0},
    MOTOR_TORQUE: {"Nm": 7.0, LESS_GRAVITY: 6.0},  # RTDE's lacks gravity, other drivers' has it
    "actual_torque": {"Nm": 7.0, LESS_GRAVITY: 5.0},
    "target_moment": {"Nm": 7.0, LESS_GRAVITY: 5.0},
    TORQUE_LESS_GRAVITY: {LESS_GRAVITY: 7.0},
    "effort": {"A": 7.0, "mA": 5.0, "Nm": 7.0, LESS_GRAVITY: 7.0, UNKNOWN: 7.0},
}
KINDS = {"mA": -1.0, LESS_GRAVITY: -2.0, UNKNOWN: -8.0}  # how common a reading is
STATED = 60.0  # nats of an option
SMALLEST_MILLIAMPERES = 20.0  # the largest of a moving arm's joint is more
MIN_BEARING_JOINTS = 2  # so many show a unit together
MAX_TORQUE_RATIO = 1.5  # of a torque in Nm to gravity's
# Up to this one, nothing else is as near; 1 % of the torque for which some motors are rated is 1.5.
MAX_PROVEN_RATIO = 1.25
# By so many nats a share is likelier beyond it, and a unit less likely that one joint contradicts.
DOUBTED = 5.0
MAX_HIDDEN_RATIO = 4.0  # of gravity to an effort that has a part of it; without it, 20 and more
MAX_FACTOR_RATIO = 1.15  # of joints' factors that show one unit
MAX_ALIKE_SLOPES, MIN_ALIKE = 1.6, 0.5  # of accelerations on slopes of velocities; correlation


class GravityShown(NamedTuple):
    """What gravity shows of an effort.

    scores: log-likelihood of each unit; constants: Nm per unit of the file, by joint from 0; known:
    the maker's constants [Nm/A], empty for joints that sense their torque; own: log-likelihood with
    one factor a joint; beside_motion: share of the squares without friction and inertia; held:
    log-likelihood with the arm's own constants, in the likeliest unit.
    """

    scores: Mapping[str, float]
    constants: Mapping[int, float]
    known: Sequence[float]
    own: float = -np.inf
    beside_motion: float = 1.0
    held: float = -np.inf

    def ratios(self, unit: str) -> list[float]:
        """Return the joints' constants as multiples of those that they would have in a unit."""
        if unit != "Nm" and not self.known:
            return []
        of_unit = {"A": 1.0, "mA": 1e-3}
        return [
            constant / (of_unit[unit] * self.known[joint] if unit in of_unit else 1.0)
            for joint, constant in self.constants.items()
        ]

    def contradicts(self, unit: str) -> bool:
        """Return whether the constant of any joint is far from that of a unit."""
        most = MAX_TORQUE_RATIO if unit == "Nm" else MAX_CONSTANT_RATIO
        return any(not 1 / most < ratio < most for ratio in self.ratios(unit))

    def confirms(self, unit: str) -> bool:
        """Return whether several joints show the maker's constants that a unit would have."""
        enough = len(self.constants) >= MIN_BEARING_JOINTS and bool(self.known or unit == "Nm")
        return enough and not self.contradicts(unit)

    def is_far_from_newton_metres(self) -> bool:
        """Return whether the median of the joints' constants is far from 1 Nm per unit of the
        file.
        """
        median = float(np.median(self.ratios("Nm") or [1.0]))
        return not 1 / MAX_PROVEN_RATIO < median < MAX_PROVEN_RATIO

    def factor(self) -> float | None:
        """Return the amperes of one unit of the file, None unless all joints show one factor."""
        ratios = self.ratios("A")
        alike = len(ratios) >= MIN_BEARING_JOINTS and max(ratios) < MAX_FACTOR_RATIO * min(ratios)
        return float(np.median(ratios)) if alike else None

    def in_words(self, unit: str = "") -> str:
        """Return the joints' constants in words, with the maker's but for Nm; "" for none."""
        if not self.constants:
            return ""
        joints = ", ".join(str(joint + 1) for joint in self.constants)
        constants = ", ".join(f"{constant:.3g}" for constant in self.constants.values())
        known = self.known if unit != "Nm" else ()
        makers = ", ".join(f"{known[joint]:.3g}" for joint in self.constants if known)
        plural = "s" if len(self.constants) > 1 else ""
        of_joints = f"{constants} Nm per unit on joint{plural} {joints}"
        return f"{of_joints} (known: {makers} Nm/A)" if known else of_joints


def shown_by_gravity(means: BlockMeans | None, arm: Robot | None, name: str) -> GravityShown:
    """Return what gravity shows of an effort by its name in `means`; empty without means or arm."""
    if means is None or arm is None:
        return GravityShown({}, {}, ())
    fit = torque_constants(means, arm, name)
    shown = {joint: ratio for joint, ratio in fit.ratio.items() if ratio < MAX_SHOWN_RATIO}
    constants = {joint: ratio * fit.known[joint] for joint, ratio in shown.items()}
    by_unit, by_makers, beside = unit_scores(means, name, arm)
    own = by_unit.pop(OWN_FACTORS)
    if arm.measured == TORQUE:  # which has no amperes
        scores = {unit: by_unit[unit] for unit in ("Nm", LESS_GRAVITY)}
        return GravityShown(scores, constants, (), own, beside, max(own, scores["Nm"]))
    held = max(by_makers[unit] for unit in UNITS)
    return GravityShown(by_unit, constants, fit.known, own, beside, held)


class EffortFacts(NamedTuple):
    """What sources are asked about: an effort, the likeliest arm, and what the user states.

    block: in the file's numbers; arm: None where nothing states one; is_known: whether it is the
    file's; units: stated for it, by channel; means: over blocks of time, with the effort `name`,
    None without a motion.
    """

    block: ColumnBlock
    arm: Robot | None
    is_known: bool
    units: Mapping[str, str]
    means: BlockMeans | None
    name: str
    shown: GravityShown


def rows_of(facts: EffortFacts) -> list[Row]:
    """Return what each source says of an effort."""
    sources = (_kind, _option, _name, _arm, _size, _gravity, _constants, _motion)
    return [row for source in sources for row in source(facts)]


def surest(rows: Sequence[Row], facts: EffortFacts) -> Confidence:
    """Return how sure a verdict on an effort may be: without a known arm, gravity and constants are
    those of a guess, and a name says neither unit nor share, nor whether gravity is in it.
    """
    stated = any(row.source in ("option", "unit") for row in rows)
    return "proven" if facts.is_known else "assumed" if stated else "check"


def _kind(facts: EffortFacts) -> Iterator[Row]:
    yield Row("kind", KINDS)


def _option(facts: EffortFacts) -> Iterator[Row]:
    """Yield the unit or the channel that the user states."""
    meaning = facts.block.meaning() or ""
    bare = meaning in ("", "effort")
    for channel, unit in facts.units.items():
        if unit in UNITS:
            stated = LESS_GRAVITY if channel == TORQUE_LESS_GRAVITY else unit
            yield Row("option", {stated: STATED}, "stated")
            return
    if facts.block.stated and meaning in NAME_ODDS and not bare:
        yield Row("option", {k: 8 * own for k, own in NAME_ODDS[meaning].items()}, "stated")


def likely_driver(facts: EffortFacts) -> str:
    """Return in words what publishes an effort less gravity, "" where nothing is known of it."""
    is_effort = facts.block.meaning() in ("effort", TORQUE_LESS_GRAVITY)
    of_ur = is_effort and facts.arm is not None and facts.arm.is_ur()
    return "; UR's ROS 2 driver publishes it since 2026 (use_currents_as_efforts)" if of_ur else ""


def is_share(block: ColumnBlock) -> bool:
    """Return whether an effort is named as a share of a rating, or as counts."""
    return not block.stated and names_share(block.names[0])


def _name(facts: EffortFacts) -> Iterator[Row]:
    """Yield what names state: a share, a unit, a quantity; the message's convention; none."""
    block, meaning = facts.block, facts.block.meaning() or ""
    spelled = named_unit(block.names[0]) or ""
    if is_share(block):
        yield Row("unit", {UNKNOWN: 22.0}, "share in name")
    elif spelled in UNITS:  # which does not say whether gravity is in it
        odds = {spelled: 14.0} | {"A": {"mA": 10.5}, "Nm": {LESS_GRAVITY: 12.0}}.get(spelled, {})
        yield Row("unit", odds, "unit in name", {"unit": spelled})
    elif meaning in NAME_ODDS and not block.stated:
        code = "" if meaning == "effort" else "named"
        yield Row("name", NAME_ODDS[meaning], code, {"name": meaning})
    elif not meaning:
        yield Row("place", {NO_EFFORT: 4.0})
    of_ur = facts.arm is not None and facts.arm.is_ur()
    if meaning in ("", "effort") and not of_ur:
        yield Row("container", {"Nm": 3.0})


def _arm(facts: EffortFacts) -> Iterator[Row]:
    """Yield what the arm measures, by its description."""
    if facts.arm is None:
        return
    if facts.is_known and facts.arm.measured == TORQUE:
        sure = 3.0 if facts.arm.effort == "torque" else 6.0  # the default, or stated
        yield Row("arm", {"A": -sure, "mA": -sure}, "measures torques", {"arm": facts.arm.name})
    elif facts.arm.is_ur():
        yield Row("arm", {"Nm": -2.0, LESS_GRAVITY: -1.0})


def _size(facts: EffortFacts) -> Iterator[Row]:
    """Yield what follows from the size: no current is above a bound, none in mA below another."""
    peak = float(np.nanmedian(np.abs(facts.block.rows).max(axis=1)))
    bound = CHANNELS[MEASURED_CURRENT].bound
    if peak > bound:  # counts are as large as mA, which constants, a unit or an option tell
        named = named_unit(facts.block.names[0]), *facts.units.values()
        shown = facts.shown.constants and facts.shown.known
        told = "mA" in named or (shown and not facts.shown.contradicts("mA"))
        odds = {"A": -30.0} if told else {"A": -30.0, "mA": -DOUBTED}
        yield Row("bounds", odds, "too large", {"peak": peak, "bound": bound})
    elif peak < SMALLEST_MILLIAMPERES:
        yield Row("bounds", {"mA": -12.0})


def _gravity(facts: EffortFacts) -> Iterator[Row]:
    """Yield how well gravity explains each unit, or that it is not in the effort; nothing where
    neither is shown.

    That gravity is absent proves nothing, as it is where an axis is coupled, a hand pushes, or an
    arm rests: motion alone must explain the effort.
    """
    shown, arm = facts.shown, facts.arm
    if not shown.scores or arm is None:
        return
    bearing, several = _bearing(shown), len(shown.constants) >= MIN_BEARING_JOINTS
    likely, none = max(bearing, key=lambda unit: bearing[unit]), shown.scores[LESS_GRAVITY]
    best = bearing[likely]
    if none - shown.held > CLEAR_LEAD and shown.beside_motion < MAX_BESIDE_MOTION:
        share = {"share": 1 - shown.beside_motion}
        yield Row(
            "gravity absent", dict.fromkeys((LESS_GRAVITY, NO_EFFORT), 8.0), "gravity absent", share
        )
        return
    held = max(shown.held, shown.own if several else -np.inf)
    if held - none < CLEAR_LEAD:
        return
    odds = {unit: bearing.get(unit, -np.inf) - best for unit in UNITS}
    odds[LESS_GRAVITY] = odds[NO_EFFORT] = min(0.0, none - held)
    strange = several and shown.contradicts(likely)
    odds[UNKNOWN] = min(0.0, shown.own - best) if strange else -CLEAR_LEAD
    source = "gravity" if arm.is_ur() else "own links"
    yield Row(source, odds, *_words_on(shown, likely), exact=several)


def _bearing(shown: GravityShown) -> dict[str, float]:
    """Return the log-likelihood of each unit of an effort that bears gravity, without those that
    constants of several joints exclude, unless they exclude all: a push at rest looks like gravity.
    """
    bearing = {unit: own for unit, own in shown.scores.items() if unit != LESS_GRAVITY}
    if not shown.known:  # any factors may be constants, unless they are those of Nm
        bearing["A"] = bearing["Nm"] if shown.confirms("Nm") else shown.own
    several = len(shown.constants) >= MIN_BEARING_JOINTS
    possible = [unit for unit in bearing if not (several and shown.contradicts(unit))]
    return {unit: bearing[unit] for unit in possible or bearing}


def _words_on(shown: GravityShown, likely: str) -> tuple[str, dict[str, object]]:
    """Return code and numbers of the words on gravity: the likeliest unit and the next; "" where
    scores alone say otherwise than constants do.
    """
    best, rival = sorted(shown.scores, key=lambda unit: -shown.scores[unit])[:2]
    units: dict[str, object] = {"unit": CANDIDATES[best], "rival": CANDIDATES[rival]}
    lead = shown.scores[best] - shown.scores[rival]
    return "by gravity" if best == likely else "", units | {"lead": lead}


def _constants(facts: EffortFacts) -> Iterator[Row]:
    """Yield the units whose constants several joints show, or that none has them."""
    shown, arm, block_name = facts.shown, facts.arm, facts.block.names[0]
    units = [unit for unit in UNITS if unit == "Nm" or shown.known]
    if len(shown.constants) == 1 and arm is not None and arm.is_ur():
        doubted = {unit: -DOUBTED for unit in units if shown.contradicts(unit)}
        if max(shown.ratios("Nm")) < MAX_HIDDEN_RATIO:
            doubted |= dict.fromkeys((LESS_GRAVITY, NO_EFFORT), -DOUBTED)
        yield Row("constants", doubted, "other constants", {"constants": shown.in_words()})
    if len(shown.constants) < MIN_BEARING_JOINTS or arm is None:
        return
    near = [unit for unit in units if shown.confirms(unit)]
    if _lacks_gravity(shown) and not (shown.known and near):
        return
    far = [unit for unit in units if shown.contradicts(unit)] if arm.is_ur() else []
    others = dict.fromkeys(CANDIDATES, -CLEAR_LEAD)
    if near == ["Nm"] and shown.is_far_from_newton_metres() and named_unit(block_name) != "Nm":
        yield Row("constants", others | {UNKNOWN: 0.0, "Nm": -DOUBTED}, "share as near")
    elif near:
        units_near, numbers = dict.fromkeys(near, 0.0), {"constants": shown.in_words(near[0])}
        yield Row("constants", others | units_near, "constants shown", numbers, exact=True)
    elif far:
        right = dict.fromkeys([*(unit for unit in units if unit not in far), UNKNOWN], 0.0)
        numbers = {"constants": shown.in_words()}
        alike = shown.factor() is not None and len(far) == len(units)
        least = dict.fromkeys(UNITS, -12.0) if alike else {}
        code = "one factor" if alike else "other constants"
        yield Row("constants", others | right | least, code, numbers)


def _lacks_gravity(shown: GravityShown) -> bool:
    """Return whether neither the arm's constants nor factors of joints show that gravity is in."""
    return max(shown.held, shown.own) - shown.scores[LESS_GRAVITY] < CLEAR_LEAD


def _motion(facts: EffortFacts) -> Iterator[Row]:
    """Yield that a nameless block is one of accelerations."""
    if facts.means is not None and facts.name in facts.means.currents and facts.block.is_nameless():
        yield from _as_accelerations(facts.means, facts.name)


def _as_accelerations(means: BlockMeans, name: str) -> Iterator[Row]:
    """Yield a row if a block is the slopes of velocities by one factor, as no efforts are."""
    pairs = [*zip(means.currents[name].T, means.qdd.T, strict=True)]
    alike = np.nan_to_num(correlation(means.currents[name], means.qdd))
    slopes = np.array([own @ qdd / (qdd @ qdd + SMALLEST_SIZE) for own, qdd in pairs])
    clear = slopes[alike > MIN_ALIKE]
    if 2 * len(clear) > len(slopes) and clear.max() < MAX_ALIKE_SLOPES * clear.min():
        factor = {"factor": float(np.median(clear))}
        yield Row("motion", {NO_EFFORT: 12.0}, "accelerations", factor)

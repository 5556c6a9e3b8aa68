"""How often right logs of real and simulated arms are stopped, and which faults in them are told.

    python -m benchmarks.false_stops [--folder ../shared] [--quick] [--right] [seeds]

Right logs are those of the real arms in a folder of reference data, by the studies of the workflow
or by entries made here, and drawn ones of simulated arms: Universal Robots, arms of seven joints by
currents and by torque sensors, and industrial ones with big gears whose links nobody knows. Each is
checked as recorded, with positions, velocities and efforts alone, as most logs are, and with links
that are described wrongly. Faults are put into the second, one at a time, where its joints move. A
stop sign that names another cause, or other joints, counts as told otherwise; without one, warnings
of delays, loads and currents count. With --right, right logs of simulated arms alone: 50 seeds are
200 logs.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from benchmarks.harness.markdown import markdown
from benchmarks.harness.options import options_of
from benchmarks.harness.right_logs import RightLog, real_logs, simulated_logs, wrongly_described
from ur5lib.checks.arm import Pair
from ur5lib.checks.checked import MIN_BLOCKS, Checked
from ur5lib.checks.currents import moving_joints
from ur5lib.checks.findings import load_without_targets, possible_delays, scaled_current
from ur5lib.checks.readings import exchanged_order, in_order
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.checks.unchecked import unchecked
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Payload
from ur5lib.robots.statics import flange_kinematics, gravity_torque
from ur5lib.tables import channel, named
from ur5lib.timeseries.arrays import Array

SEEDS = 8
DELAYS, SCALE, UNIT = (0.05, 0.3), 0.6, 1000.0  # s; of one joint's efforts; of all
DELAY_OF_A_JOINT = 0.1  # s
PACE = 1.25  # of a clock
STIFFNESS = 300.0  # N/m
TOOL = Payload(mass=2.6, center_of_mass=(0.02, 0.0, 0.08))
DOUBT = Found.LINKS_IN_DOUBT


class Fault(NamedTuple):
    """A log with a fault, and the stop sign that it should raise.

    joints: from 1, that the sign should name, if any; words: one of these should be in its code.
    """

    kind: str
    checked: Checked
    joints: set[int]
    words: tuple[str, ...]


def main() -> None:
    """Print how right logs and faults are judged."""
    options = options_of(__doc__)
    options.add_argument("seeds", nargs="?", type=int, default=SEEDS, help="logs of each kind")
    options.add_argument("--folder", type=Path, default=Path("../shared"), help="reference data")
    options.add_argument("--right", action="store_true", help="right simulated logs alone")
    given = options.parse_args()
    logs = [*simulated_logs(1 if given.quick else given.seeds)]
    logs += [] if given.quick or given.right else [*real_logs(given.folder)]
    print(f"{len(logs)} right logs")
    right = pd.DataFrame([row for own in logs for row in of_right(own)])
    print(table(right, ["arm", "as"]))
    for _, row in right[right["stop sign or warning"] != ""].iterrows():
        print(f"- {row['log']}, {row['as']}: {row['stop sign or warning']}")
    if given.right:
        return
    faulty = pd.DataFrame([row for own in logs for row in of_faults(own)])
    print(table(faulty, ["fault"]))
    print(table(faulty, ["arm"]))
    for (kind, outcome), rows in faulty[faulty["told"] == 0].groupby(["fault", "outcome"]):
        print(f"- {kind}, {outcome}: {', '.join(rows['log'])}")


def table(rows: pd.DataFrame, keys: list[str]) -> str:
    """Return a table of the rows' counts, summed by the columns `keys`."""
    counts = rows.groupby(keys, sort=False).sum(numeric_only=True).reset_index()
    return markdown([*counts], [[*map(str, row)] for row in counts.itertuples(index=False)])


def of_right(log: RightLog) -> Iterator[dict[str, object]]:
    """Yield how a right log is judged: as recorded, by its motion alone, and described wrongly."""
    recorded = replace(log.checked)  # cached results, some 50 MB a log, are freed with the copy
    forms = [("recorded", recorded), ("motion alone", bare(recorded))]
    forms += [("links described wrongly", own) for own in wrongly_described(bare(recorded))]
    for name, own in forms:
        stops = stop_signs(own)
        doubts = [] if stops else [one for one in unchecked(own) if one.code == DOUBT]
        warned = [] if stops else warnings(own)
        counts = {"logs": 1, "stopped": int(bool(stops)), "warned": int(bool(warned))}
        counts["doubted"] = int(bool(doubts))
        code = ", ".join(f"{one.cause} ({one.detail})" for one in stops or warned)
        yield {"arm": log.arm, "log": log.name, "as": name, **counts, "stop sign or warning": code}


def warnings(own: Checked) -> list[Finding]:
    """Return the warnings about a log without a stop sign."""
    return [*possible_delays(own), *load_without_targets(own), *scaled_current(own)]


def of_faults(log: RightLog) -> Iterator[dict[str, object]]:
    """Yield the verdict on each fault that is put into a log."""
    for fault in faults(bare(log.checked)):
        stops = stop_signs(fault.checked) or warnings(fault.checked)
        told = any(is_told(fault, sign) for sign in stops)
        outcome = "told" if told else "told otherwise" if stops else "unnoticed"
        counts = {name: int(name == outcome) for name in ("told", "told otherwise", "unnoticed")}
        about = {"arm": log.arm, "fault": fault.kind, "log": log.name, "outcome": outcome}
        yield about | {"logs": 1, **counts}


def is_told(fault: Fault, sign: Finding) -> bool:
    """Return whether a finding names a fault and its joints."""
    right = not fault.joints or {*sign.joints} == fault.joints
    return right and any(word in (sign.cause or "") for word in fault.words)


def moved(own: Checked) -> tuple[str, ...]:
    """Return the channels in which joints can be exchanged."""
    return "actual_q", "actual_qd", own.arm.measured.channel


def bare(own: Checked) -> Checked:
    """Return a log with its positions, velocities and efforts alone."""
    kept = ("time", "segment", "interpolated", *moved(own))
    names = [name for name in own.robot if name.startswith(kept)]
    return Checked(own.robot[names], own.arm, own.configured, own.declared, own.fitted, own.cutoff)


def faults(own: Checked) -> Iterator[Fault]:
    """Yield a log with each kind of fault; none if no joint moves or no effort was recorded."""
    if f"{own.arm.measured.channel}_0" not in own.robot or len(own.means.q) < MIN_BLOCKS:
        return
    moving = np.flatnonzero(moving_joints(own.means)).tolist()
    random = np.random.default_rng(len(own.robot))
    if len(moving) > 1:
        pairs = [*combinations(moving, 2)]
        chosen = random.choice(len(pairs), 2)
        yield from exchanged(own, *(pairs[k] for k in chosen))
    if moving:
        yield from of_a_joint(own, int(random.choice(moving)))
        yield from of_all_joints(own)
        yield from of_the_whole(own)
        if own.arm.tells_gravity():
            yield Fault("a tool of 2.6 kg", with_tool(own), set(), ("load",))
        kind = f"a spring of {STIFFNESS:g} N/m on the tool"
        yield Fault(kind, with_spring(own, STIFFNESS), set(), ("spring",))
        others = [one for one in own.others if one.joints != own.arm.joints]
        if own.arm.has_ur_motors() and others:
            other = replace(own, arm=others[random.integers(len(others))])
            yield Fault("another arm declared", other, set(), ("other arm", "known cause"))


def exchanged(own: Checked, pair: Pair, other: Pair) -> Iterator[Fault]:
    """Yield a log with efforts of two joints exchanged, and with all channels of another two."""
    order, order_of_all = ([*exchanged_order(in_order(own.arm), *two)] for two in (pair, other))
    words = ("exchanged currents",)
    efforts = spoilt(own, channel(own.robot, own.arm.measured.channel)[:, order])
    yield Fault("efforts of two joints exchanged", efforts, {j + 1 for j in pair}, words)
    table = own.robot.copy()
    for name in moved(own):
        if f"{name}_0" in table:
            table = table.assign(**named(channel(own.robot, name)[:, order_of_all], name))
    all_of_them = replace(own, robot=table)
    yield Fault(
        "all of two joints exchanged", all_of_them, {j + 1 for j in other}, ("exchanged joints",)
    )


def of_a_joint(own: Checked, joint: int) -> Iterator[Fault]:
    """Yield logs with the effort of a joint negated, scaled, and delayed."""
    effort, factor = channel(own.robot, own.arm.measured.channel), np.ones(len(own.arm.joints))
    for kind, size, words in (
        ("sign of a joint", -1, ("turned", "opposite")),
        (f"{SCALE} of a joint's effort", SCALE, ("foreign constant", "scaled")),
    ):
        factor[joint] = size
        yield Fault(kind, spoilt(own, effort * factor), {joint + 1}, words)
    late = effort.copy()
    late[:, joint] = delayed(effort[:, [joint]], DELAY_OF_A_JOINT / own.step)[:, 0]
    kind = f"a joint's effort {DELAY_OF_A_JOINT} s late"
    yield Fault(kind, spoilt(own, late), {joint + 1}, ("late",))


def delayed(values: Array, frames: float) -> Array:
    """Return values (N, n) delayed by a number of frames."""
    return np.asarray(pd.DataFrame(values).shift(round(frames)).bfill().to_numpy())


def with_tool(own: Checked) -> Checked:
    """Return a fit log with the gravity torque of an undeclared tool added."""
    q = channel(own.robot, "actual_q")
    arms = own.arm.carrying(TOOL), own.arm
    more, less = (gravity_torque(arm, arm.chosen_model, q) for arm in arms)
    effort = channel(own.robot, own.arm.measured.channel)
    added = (more - less) / np.array(own.arm.maker_torque_constants())
    return replace(spoilt(own, effort + added), fitted=True)


def with_spring(own: Checked, stiffness: float) -> Checked:
    """Return a fit log with efforts that hold a spring [N/m], relaxed at the tool's mean place."""
    _, place, jacobian = flange_kinematics(own.arm, np.nan_to_num(channel(own.robot, "actual_q")))
    force = stiffness * (place.mean(axis=0) - place)
    added = np.einsum("nij,ni->nj", jacobian[:, :3], force) / own.arm.maker_torque_constants()
    effort = channel(own.robot, own.arm.measured.channel)
    return replace(spoilt(own, effort - added), fitted=True)


def of_all_joints(own: Checked) -> Iterator[Fault]:
    """Yield logs with all efforts negated, in another unit, and delayed."""
    effort = channel(own.robot, own.arm.measured.channel)
    of_signs = ("turned", "opposite", "mounting or sign")
    yield Fault("sign of all joints", spoilt(own, -effort), set(), of_signs)
    of_units = ("mA", "no current", "foreign size", "foreign constant")
    yield Fault("efforts 1000 times as large", spoilt(own, UNIT * effort), set(), of_units)
    for delay in DELAYS:
        late = delayed(effort, delay / own.step)
        yield Fault(f"efforts {delay} s late", spoilt(own, late), set(), ("late",))


def of_the_whole(own: Checked) -> Iterator[Fault]:
    """Yield a log with gravity declared from the side, and one with stamps that run too fast, which
    velocities show if they were recorded.
    """
    sideways = own.arm.mounted(np.roll(own.arm.gravity, 1).tolist())
    yield Fault("gravity from the side", replace(own, arm=sideways), set(), ("other mounting",))
    if "actual_qd_0" in own.robot:
        fast = own.robot.assign(time=PACE * own.robot["time"])
        kind = f"a clock {PACE} times too fast"
        yield Fault(kind, replace(own, robot=fast), set(), ("clock",))


def spoilt(own: Checked, efforts: Array) -> Checked:
    """Return a log with these efforts."""
    return replace(own, robot=own.robot.assign(**named(efforts, own.arm.measured.channel)))


if __name__ == "__main__":
    main()

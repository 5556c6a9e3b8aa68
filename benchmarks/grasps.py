"""Which loads that are taken up within a recording are found: a part of docs/benchmark.md.

    python -m benchmarks.grasps [--folder ../shared] [--page] [--quick] [count]

Into UR10e and UR3 recordings without contact, the gravity torque of a load of 0.5 to 3 kg is put by
the maker's torque constants, at drawn times. It is found if it alone is told, with both times right
within 1 s. Where only other joints move, gravity may hardly show it. Pieces of all
recordings, and of the default study's motions with other seeds and pauses, are looked at as they
are, and with a push of 2 s and 10 to 60 N, whose force swings. `--page` writes the part.
"""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from benchmarks.harness.markdown import markdown, read_page, replaced, write_page
from benchmarks.harness.options import options_of
from benchmarks.harness.right_logs import PROJECT, RightLog, checked, real_logs
from ur5lib.checks.checked import Checked
from ur5lib.checks.load_changes import MIN_HELD, HeldLoad, held_loads
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import geometric_jacobian, load_torque
from ur5lib.stand.layout import ROBOT_FILES
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.tables import channel, named
from ur5lib.timeseries.arrays import Array

PAGE = PROJECT / "docs" / "benchmark.md"
TITLE = "Loads that change"
COUNT = 100
ARMS, PAUSES = ("ur5", "ur10", "ur3", "ur5e"), (0.5, 1.0, 3.0, 5.0)  # s
WITH_CONTACT = ("push", "-load", "Load")  # in names of UR10e recordings
WITHIN, TAKEN_UP = 1.0, 0.3  # s
MOVES = 0.1  # rad; joints 2 or 3 vary by more, so that the load's torque changes
PUSHED = 2.0  # s
PIECE = 8.0, 45.0  # s


def main() -> None:
    """Print how many loads are found, and how often there is none."""
    options = options_of(__doc__)
    options.add_argument("count", nargs="?", type=int, default=COUNT, help="of each kind")
    options.add_argument("--folder", type=Path, default=Path("../shared"), help="reference data")
    options.add_argument("--page", action="store_true", help="write docs/benchmark.md as well")
    given = options.parse_args()
    count = 2 if given.quick else given.count
    still = [*simulated(1 if given.quick else len(ARMS))]
    logs = [*still, *([] if given.quick else real_logs(given.folder))]
    logs = [own for own in logs if is_long(own.checked)]
    free = [own for own in logs if own.arm in ("ur10e", "ur3") and is_free(own.name)] or logs
    text = markdown(["what", "of", "told"], [*of_loads(free, count), *of_none(logs, count)])
    print(text)
    if given.page:
        write_page(replaced(read_page(PAGE), TITLE, text), PAGE)


def is_free(name: str) -> bool:
    """Return whether nothing touches the arm, and it carries nothing, in a recording."""
    return not any(part in name for part in WITH_CONTACT)


def is_long(own: Checked) -> bool:
    """Return whether a log is asked for loads at all."""
    if not own.shows_currents() or not own.arm.tells_gravity() or len(own.arm.joints) != 6:
        return False
    return bool(np.ptp(own.robot["time"]) > 2 * MIN_HELD + 1)


def simulated(seeds: int) -> Iterator[RightLog]:
    """Yield the default study's motions with other seeds, pauses and arms, their contacts left
    out.
    """
    for entry in yaml.safe_load((PROJECT / "config.yaml").read_text())["recordings"]:
        for seed in range(seeds):
            plan = dict(entry["simulate"]) | {"seed": entry["simulate"]["seed"] + 100 * seed}
            for sensor in ("imu", "force_sensor", "faults", "contacts"):
                plan.pop(sensor, None)
            if seed and plan["trajectory"]["kind"] == "movej":
                plan["trajectory"] = plan["trajectory"] | {"pause_s": PAUSES[seed]}
            arm = load_robot(robot_path(ARMS[seed]))
            with tempfile.TemporaryDirectory() as name:
                folder, motion = Path(name), SimulatedRecording.model_validate(plan)
                simulate(arm, motion, "rtde-csv", folder, folder / "t")
                files = {"format": "rtde-csv", "file": ROBOT_FILES["rtde-csv"], "folder": name}
                yield RightLog("simulated", entry["name"], checked(files, arm))


def of_loads(logs: Sequence[RightLog], count: int) -> Iterator[list[str]]:
    """Yield how many drawn loads are found, by mass, and the error of their masses."""
    masses, shown, found, errors = [], [], [], []
    for seed in range(count):
        random = np.random.default_rng(seed)
        own = logs[int(random.integers(len(logs)))].checked
        time = own.robot["time"].to_numpy()
        lasts = float(np.ptp(time))
        mass = random.uniform(0.5, 3.0)
        center = np.array([*random.normal(0, 0.03, 2), random.uniform(0.02, 0.12)])
        held = random.uniform(4.0, max(4.0, min(30.0, lasts - 3)))
        start = time[0] + random.uniform(1.5, max(1.6, lasts - 1.5 - held))
        end = start + held if random.random() < 0.75 else np.inf
        torque = load_torque(own.arm, channel(own.robot, "actual_q")) @ [mass, *mass * center]
        told = held_loads(added(own, torque * ramp(time, start, end)).means, own.loaded)
        masses.append(mass)
        shown.append(channel(own.robot, "actual_q")[:, 1:3].std(axis=0).max() > MOVES)
        found.append(len(told) == 1 and is_at(told[0], start, min(end, time[-1]), time[-1]))
        errors.append(told[0].mass / mass - 1 if found[-1] else np.nan)
    heavy, seen = np.array(masses) > 1, np.array(found)
    for words, of in (
        ("loads above 1 kg", heavy),
        ("of these, while joint 2 or 3 moves", heavy & np.array(shown)),
        ("loads up to 1 kg", ~heavy),
    ):
        yield [words, str(of.sum()), str((seen & of).sum())]
    size = np.nanmedian(np.abs(errors)) if seen.any() else np.nan
    yield ["median error of their masses", str(seen.sum()), f"{size:.0%}"]


def is_at(told: HeldLoad, start: float, end: float, last: float) -> bool:
    """Return whether a load has the right times [s]; last: of the recording."""
    late = (told.end or last) - end
    return told.start is not None and max(abs(told.start - start), abs(late)) < WITHIN


def of_none(logs: Sequence[RightLog], count: int) -> Iterator[list[str]]:
    """Yield how many pieces without a load are told to have one, as they are and with a push."""
    for words, change in (("unloaded pieces", lambda own, _: own), ("pushes of 2 s", pushed)):
        yield [words, str(count), str(sum(tells(logs, seed, change) for seed in range(count)))]


def tells(
    logs: Sequence[RightLog],
    seed: int,
    change: Callable[[Checked, np.random.Generator], Checked],
) -> bool:
    """Return whether a load is told in a drawn piece of a log, changed."""
    random = np.random.default_rng(COUNT + seed)
    own = logs[int(random.integers(len(logs)))].checked
    time = own.robot["time"].to_numpy()
    lasts = min(float(np.ptp(time)), random.uniform(*PIECE))
    first = time[0] + random.uniform(0, np.ptp(time) - lasts)
    rows = (time >= first) & (time <= first + lasts)
    piece = change(replace(own, robot=own.robot[rows].reset_index(drop=True)), random)
    return bool(held_loads(piece.means, piece.loaded))


def pushed(own: Checked, random: np.random.Generator) -> Checked:
    """Return a log with a push at the flange."""
    time, q = own.robot["time"].to_numpy(), channel(own.robot, "actual_q")
    start = time[0] + random.uniform(0.5, np.ptp(time) - PUSHED - 0.5)
    direction = random.normal(size=3)
    force = random.uniform(10, 60) * direction / np.linalg.norm(direction)
    since = np.clip((time - start) / PUSHED, 0, 1)
    swing = 1 + 0.3 * np.sin(2 * np.pi * random.uniform(1, 4) * since)
    size = np.sin(np.pi * since) ** random.choice([0.3, 1.0, 2.0]) * swing
    turned = np.einsum("nij,i->nj", geometric_jacobian(own.arm, q)[:, :3], force)
    return added(own, -turned * size[:, None])


def ramp(time: Array, start: float, end: float) -> Array:
    """Return the share (N, 1) of a load that is carried."""
    up, down = ((at / TAKEN_UP + 0.5).clip(0, 1) for at in (time - start, end - time))
    return np.asarray((up * down)[:, None])


def added(own: Checked, torque: Array) -> Checked:
    """Return a log with efforts of a further torque (N, n) [Nm]."""
    name = own.arm.measured.channel
    effort = channel(own.robot, name) + torque / np.array(own.arm.maker_torque_constants())
    return replace(own, robot=own.robot.assign(**named(effort, name)))


if __name__ == "__main__":
    main()

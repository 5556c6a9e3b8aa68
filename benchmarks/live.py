"""The live estimate of a built study: how long a step takes, and what it tells on dates left out.

Time beside Pinocchio's inverse dynamics of the same arm, in one run. Then noise and threshold are
learnt without the recordings of a date, and friction without their paths, and these recordings are
followed as they are, and with pushes at the flange: drawn ones, and one of 10 N held for 10 s.
"""

import json
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd
import pinocchio
import torch

from benchmarks.harness.drawn_pushes import drawn_pushes
from benchmarks.harness.options import arm_options, built
from ur5lib.errors import InputError
from ur5lib.records.measured import Measured
from ur5lib.robots.description import load_robot
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.strict import read_yaml
from ur5lib.study.model import CurrentLowpass
from ur5lib.timeseries.segments import runs as stretches
from ur5lib.timeseries.trajectories import REST_SPEED
from ur5lib.topics.live.live import FORMAT, Live
from ur5lib.topics.live.live_file import learned
from ur5lib.topics.live.live_recording import Followed, follow
from ur5rivals.estimators.ours_live import inputs
from ur5rivals.run import Run
from ur5rivals.study import read_arms

FALSE_PER_MIN = 1.0
LONG = 40.0  # s; least duration of a long run
HELD, LASTS = 10.0, 10.0  # N, s
AFTER_STOP = 3.0  # s
REST = AFTER_STOP + LASTS + 1.0  # s; least duration of a long rest
HEADER = Path(__file__).parents[1] / "ur5lib" / "topics" / "live"
SOURCE = Path(__file__).parent / "harness" / "live_samples.cpp"


def main() -> None:
    """Print times and results."""
    given = arm_options(__doc__).parse_args()
    [folder] = built([Path("results") / given.study])
    torch.set_num_threads(1)
    [arm] = [own for own in read_arms(folder) if own.robot == given.robot]
    runs = [run for run in [*arm.fit, *arm.free] if run.measured is not None]
    entries = read_yaml(folder / "configuration.yaml")["recordings"]
    dates = {entry["name"]: str(entry.get("date") or entry["name"]) for entry in entries}
    if given.quick:
        arm.fit[:] = sorted(arm.fit, key=lambda own: -np.abs(own.qd).mean())[:3]  # some stand still
        runs = runs[:1]
    known = learned_on(arm.fit)
    print_times(folder / "parameters" / given.robot / "arm.yaml", runs[0], known)
    rows = [row for date in sorted({dates[own.name] for own in runs})
            for row in on_date(date, runs, arm.fit, dates)]  # fmt: skip
    report(pd.DataFrame(rows))


def learned_on(runs: list[Run]) -> dict[str, Any]:
    """Speeds, noise and threshold learnt from runs without contact."""
    return learned(
        [own for own in map(inputs, runs) if own is not None],
        len({own.path for own in runs}),
        FALSE_PER_MIN,
    )


def of(run: Run) -> tuple[dict[str, Any], Measured]:
    """The numbers of a run's arm, and its controller's samples."""
    known = inputs(run)
    assert known is not None
    return known


def answers(run: Run, known: dict[str, Any]) -> Followed:
    """The estimator's answers to a run; known: as learnt by `learned_on`."""
    arm, measured = of(run)
    return follow({**arm, **known}, measured)


def print_times(arm_file: Path, run: Run, known: dict[str, Any]) -> None:
    """Print median and 99th percentile of a step's time [µs]."""
    arm, measured = of(run)
    part, arm = measured.at(slice(2000)), {**arm, **known}
    robot = load_robot(arm_file)
    text = urdf(robot, rigid_bodies(robot, robot.fullest_model()))
    model = pinocchio.buildModelFromXML(text)
    data, estimator = model.createData(), Live(arm)
    velocities = np.zeros_like(part.q) if part.qd is None else part.qd
    took: dict[str, list[float]] = {"NumPy, a step": [], "Pinocchio, rnea": []}
    for time, q, qd, current in zip(part.time, part.q, velocities, part.current, strict=True):
        for name, call in (
            ("NumPy, a step", lambda: estimator.step(time, q, qd, current)),  # noqa: B023
            ("Pinocchio, rnea", lambda: pinocchio.rnea(model, data, q, qd, qd)),  # noqa: B023
        ):
            start = perf_counter()
            call()
            took[name].append(1e6 * (perf_counter() - start))
    for name, times in took.items():
        median, late = np.quantile(times, [0.5, 0.99])
        print(f"{name}: median {median:.1f} us, 99th percentile {late:.1f} us")
    print(f"C++, a step: {in_cpp(arm, part)}", flush=True)


def in_cpp(arm: dict[str, Any], run: Measured) -> str:
    """Return the compiled header's output about its steps."""
    if (compiler := shutil.which("g++")) is None:
        return "no g++ is installed"
    with tempfile.TemporaryDirectory() as folder:
        program, file = Path(folder) / "live_samples", Path(folder) / "arm.json"
        flags = ["-std=c++17", "-O2", "-Wno-mismatched-new-delete", f"-I{HEADER}"]
        subprocess.run([compiler, *flags, SOURCE, "-o", program], check=True)
        exported = {"format": FORMAT, "input": "current", "motor_constant": arm["torque_constant"]}
        file.write_text(json.dumps(exported | arm))
        velocities = np.zeros_like(run.q) if run.qd is None else run.qd
        rows = np.column_stack([run.time, run.q, velocities, run.current]).tolist()
        lines = "\n".join(" ".join(map(repr, row)) for row in rows)
        done = subprocess.run([program, file], input=lines, capture_output=True, text=True)
        return done.stderr.partition("\n")[0]


def on_date(
    date: str, runs: list[Run], fit: list[Run], dates: dict[str, str]
) -> Iterator[dict[str, Any]]:
    """Yield a row for each recording of a date, learning without this date."""
    others = [own for own in fit if dates[own.name] != date]
    try:
        known = learned_on(others)
    except InputError as error:
        print(f"{date}: {error}")
        return
    for own in runs:
        if dates[own.name] == date:
            found = answers(own, known)
            row = {"date": date, "recording": own.name, "alarms": len(found.alarms())}
            row |= {"minutes": len(own.q) * own.period / 60, "known": float(found.known.mean())}
            row |= held_push(own, known) | dict(zip(*drawn(own, known), strict=True))
            print(row, flush=True)
            yield row


def held_push(run: Run, known: dict[str, Any]) -> dict[str, float]:
    """Return the share of a push of 10 N that the slow state keeps after 10 s (held), and its error
    just after the release (left), relative to an estimator without slow state.

    Medians over the axes; in motion, from a third of the recording on, and in a long rest.
    """
    seconds = np.arange(len(run.q)) * run.period
    starts = {"": seconds[-1] / 3}
    still = np.asarray((np.abs(run.qd) < REST_SPEED).all(axis=1))
    for first, last in stretches(still).tolist():
        if (last - first) * run.period > REST:
            starts[" at rest"] = first * run.period + AFTER_STOP
    found: dict[str, float] = {}
    for state, start in starts.items():
        if seconds[-1] > start + LASTS + 1:
            stays, left = held_from(start, run, known)
            found |= {f"held{state}": stays, f"left{state}": left}
    return found


def held_from(start: float, run: Run, known: dict[str, Any]) -> list[float]:
    """Return held and left, as in `held_push`, for a push that starts at a time [s]."""
    seconds = np.arange(len(run.q)) * run.period
    inside = (seconds >= start) & (seconds < start + LASTS)
    frozen = {**known, "constants": known["constants"] | {"slow": 1e12}}
    shown = []
    for axis in range(3):
        pushed = run.pushed(np.nan_to_num(HELD * run.jacobian[:, axis] * inside[:, None]))
        both = [
            answers(pushed, own).wrench[:, axis] - answers(run, own).wrench[:, axis]
            for own in (known, frozen)
        ]
        held, gone = (
            [one[(seconds >= start + a) & (seconds < start + b)].mean() for one in both]
            for a, b in ((LASTS - 0.5, LASTS), (LASTS + 0.2, LASTS + 0.7))
        )
        shown.append([held[0] / held[1], gone[0] / held[1]])
    return np.median(shown, axis=0).tolist()


def drawn(run: Run, known: dict[str, Any]) -> tuple[list[str], list[float]]:
    """Return names and values: number of drawn pushes, of found ones, median delay [s]."""
    wrench = next(drawn_pushes(np.arange(float(len(run.q))) * run.period, CurrentLowpass()))
    torque = (run.jacobian.mT @ wrench[..., None])[..., 0]
    found = answers(run.pushed(np.nan_to_num(torque)), known)
    size = np.linalg.norm(wrench[:, :3], axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], size > HELD, [False]])))
    delays = []
    for first, last in edges.reshape(-1, 2):
        inside = found.contact[first:last]
        if found.known[first:last].all():
            delays.append(int(np.argmax(inside)) * run.period if inside.any() else np.inf)
    late = np.array(delays)
    names = ["pushes", "found", "delay"]
    seen = late[np.isfinite(late)]
    return names, [len(late), len(seen), float(np.median(seen)) if len(seen) else np.nan]


def report(rows: pd.DataFrame) -> None:
    """Print the results over all recordings."""
    minutes = (rows["minutes"] * rows["known"]).sum()
    unknown = 1 - rows[rows["minutes"] >= LONG / 60]["known"].mean()
    print(
        f"{rows['alarms'].sum() / minutes:.2f} alarms a minute ({rows['alarms'].sum()} in "
        f"{minutes:.1f} min of known time), unknown {unknown:.1%} of long runs; of pushes above "
        f"{HELD:.0f} N found {rows['found'].sum():.0f} of {rows['pushes'].sum():.0f}, after "
        f"{rows['delay'].median():.2f} s"
    )
    for state in ("", " at rest"):
        if f"held{state}" in rows:
            held, left = rows[f"held{state}"].dropna(), rows[f"left{state}"].dropna()
            print(
                f"of a push of {HELD:.0f} N held for {LASTS:.0f} s{state}, "
                f"{held.median():.0%} stay (least {held.min():.0%}), and {left.abs().median():.0%} "
                f"are left after its release (most {left.abs().max():.0%})"
            )


if __name__ == "__main__":
    main()

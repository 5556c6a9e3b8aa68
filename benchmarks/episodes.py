"""What copies of a thousand short episodes cost, with the force in each row; killed and resumed.

    python -m benchmarks.episodes [--folder raw/ur10e] [number]

Episodes of 10 s are cut from public runs of a UR10e (`ur5 fetch ur10e`) and stored as HDF5, in the
layout of DROID's trajectories; two whole runs are for the fit. `ur5 convert` is killed after
a third, and goes on with `--resume`. Printed are, by part, the processor time of an episode and the
memory; at the end, how many copies have all the data of their originals. All of it remains in
results/benchmark_episodes.
"""

import os
import shutil
import signal
import subprocess
import sys
import time
from itertools import islice
from pathlib import Path

import h5py
import numpy as np

from benchmarks.harness.options import options_of
from ur5lib.recordings.added import GROUP

PLACE = Path("results", "benchmark_episodes")
FREE = ("ur-20_01_17-ptp_10_points.csv", "ur-20_02_12-50sec_12harm.csv")
SECONDS, MAX_GAP = 10.0, 0.1  # s
LAYOUT = {  # columns of a log, by the arrays of DROID
    "observation/timestamp/robot_state/robot_timestamp_seconds": slice(0, 1),
    "observation/robot_state/joint_positions": slice(1, 7),
    "observation/robot_state/joint_velocities": slice(7, 13),
    "observation/robot_state/motor_currents_measured": slice(13, 19),
}
POLL = 2.0  # s
Ran = tuple[int, float, float]  # copies, processor [s], memory [GB]


def main() -> None:
    """Make the episodes, copy them with an interruption, and print what that took."""
    options = options_of(__doc__)
    options.add_argument("--folder", type=Path, default=Path("raw/ur10e"))
    options.add_argument("number", type=int, nargs="?", default=1000)
    given = options.parse_args()
    number = 6 if given.quick else given.number
    shutil.rmtree(PLACE, ignore_errors=True)
    write_episodes(given.folder, number)
    print(f"{'part':<10}{'copies':>8}{'processor s each':>18}{'memory GB':>12}")
    first = convert(number // 3)
    kept = {path: path.stat().st_mtime_ns for path in copies()}
    last = convert(None, "--resume")
    show("killed", (0, first[0][1], 0.0), first)
    show("resumed", (len(kept), last[0][1], 0.0), last)
    unchanged = sum(path.stat().st_mtime_ns == at for path, at in kept.items())
    print(f"copies of the first run that were kept: {unchanged} of {len(kept)}")
    whole = sum(map(is_whole, copies()))
    left = [path.name for path in (PLACE / "copies").rglob(".*")]
    print(
        f"copies with all data and the force: {whole} of {number + len(FREE)}; parts left: {left}"
    )


def write_episodes(folder: Path, number: int) -> None:
    """Write the runs for the fit, and episodes that begin at any time of the others, as HDF5."""
    (PLACE / "raw").mkdir(parents=True)
    logs = {path.name: rows_of(path) for path in sorted(folder.glob("ur-*.csv"))}
    for name in FREE:
        write(PLACE / "raw" / f"free_{Path(name).stem}.h5", logs.pop(name))
    random = np.random.default_rng(1)
    long = [rows for rows in logs.values() if np.ptp(rows[:, 0]) > SECONDS and gap(rows) < MAX_GAP]
    for k in range(number):
        rows = long[random.integers(len(long))]
        begin = random.uniform(rows[0, 0], rows[-1, 0] - SECONDS)
        part = rows[(rows[:, 0] >= begin) & (rows[:, 0] < begin + SECONDS)]
        write(PLACE / "raw" / f"day_{k // 100:02}" / f"episode_{k:04}.h5", part)


def gap(rows: np.ndarray) -> float:
    """Return the longest time [s] between two rows: some logs have pauses, or clocks that jump."""
    return float(np.abs(np.diff(rows[:, 0])).max())


def rows_of(path: Path) -> np.ndarray:
    """Return the first columns of a log (N, 19), without a torn last row."""
    lines = path.read_text().splitlines()
    whole = [line for line in lines if line.count(",") == lines[0].count(",")]
    return np.loadtxt(whole, delimiter=",")[:, :19]


def write(path: Path, rows: np.ndarray) -> None:
    """Write rows (N, 19) as the arrays of LAYOUT, and one of another kind."""
    path.parent.mkdir(exist_ok=True)
    with h5py.File(path, "w") as file:
        for name, columns in LAYOUT.items():
            file[name] = rows[:, columns].squeeze()
        file["action/gripper_position"] = np.zeros(len(rows))
        file.attrs["lab"] = "public"


def convert(until: int | None, *options: str) -> list[Ran]:
    """Run the command, and kill it after a number of copies; return how it went on."""
    raw, into = str(PLACE / "raw"), str(PLACE / "copies")
    fit = ["--robot", "ur10e", "--fit", "free*"]
    command = [sys.executable, "-m", "ur5lib", "convert", *fit, "--into", into, *options]
    with (PLACE / "log.txt").open("a") as log:
        run = subprocess.Popen([*command, raw], stdout=log, stderr=log)
        states = list[Ran]()
        while run.poll() is None:
            states += [(len(copies()), *used(run.pid))]
            if until is not None and states[-1][0] >= until:
                run.send_signal(signal.SIGKILL)
                break
            time.sleep(POLL)
    if run.wait() not in (0, 1, -signal.SIGKILL):
        sys.exit(f"{command} failed; see {PLACE / 'log.txt'}")
    begun = next((k for k, state in enumerate(states) if state[0] > states[0][0]), len(states) - 1)
    return states[begun:]


def used(process: int) -> tuple[float, float]:
    """Return processor time [s] and largest memory [GB] of a process so far."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    seconds = sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    peak = [int(line.split()[1]) for line in lines if line.startswith("VmHWM")]
    return seconds, max(peak, default=0) / 1e6


def show(what: str, begin: Ran, states: list[Ran]) -> None:
    """Print four parts of a run: copies, processor time of each, and memory."""
    ends = [states[k * (len(states) - 1) // 4] for k in range(1, 5)]
    for before, after in zip([states[0], *ends], ends, strict=False):
        made = after[0] - before[0]
        each = f"{(after[1] - before[1]) / made:.2f}" if made else "-"
        print(f"{what:<10}{after[0]:>8}{each:>18}{after[2]:>12.2f}", flush=True)


def copies() -> list[Path]:
    """Return the copies that are complete."""
    found = (PLACE / "copies").rglob("*.h5") if (PLACE / "copies").exists() else ()
    return sorted(path for path in found if not path.name.startswith("."))


def is_whole(path: Path) -> bool:
    """Return whether a copy has all arrays and attributes of its original, and the force."""
    place = path.relative_to(PLACE / "copies")
    with h5py.File(path) as copy, h5py.File(PLACE / "raw" / place) as original:
        names = list[str]()
        original.visit(names.append)
        arrays = [name for name in names if isinstance(original[name], h5py.Dataset)]
        same = all(np.array_equal(copy[name][()], original[name][()]) for name in arrays)
        same &= dict(copy.attrs) == dict(original.attrs)
        rows = len(original[next(iter(islice(LAYOUT, 1)))])
        return same and copy[GROUP]["Fmap"].shape == (rows, 6)


if __name__ == "__main__":
    main()

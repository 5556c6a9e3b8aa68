"""How time and memory grow with the length of one recording, from its CSV at 500 Hz to the report.

It simulates a minute of a UR5e in motion, which a hand pushes, and repeats it: the motion is
periodic, so that it goes on smoothly from each repetition to the next. The recordings to fit on
are computed before, and not counted. Processor time hardly depends on what else runs.
"""

import sys
import tempfile
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.harness.options import options_of
from benchmarks.study import snakemake
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate

RATE, PERIOD, REST = 500, 20, 1  # Hz; s, of the motion, which begins after a rest
FOLDER = Path("raw/benchmark_long")
RESULTS = Path("results/benchmark_long")
ENTRY = {"robot": "ur5e", "format": "rtde-csv"}


def main() -> None:
    """Print wall and processor time of each length, then these and the memory of each step."""
    options = options_of(__doc__)
    options.add_argument("minutes", type=int, nargs="*", help="lengths; default: 10 30 60")
    given = options.parse_args()
    plan, lengths = (["--dry-run"], [1]) if given.quick else ([], given.minutes or [10, 30, 60])
    fits = [fit(draw) for draw in (4, 7)]
    snakemake(study(fits), *plan)
    piece, found = periodic_piece(periods=1 if given.quick else 3), {}
    for minutes in lengths:
        write_recording(piece, minutes)
        wall, processor, _ = snakemake(study([*fits, LONG]), *plan)
        print(f"{minutes:>3} min: {wall:.0f} s, {processor:.0f} s of processor time", flush=True)
        if not given.quick:
            expect_read()
        found[f"{minutes} min"] = steps()
    print(pd.concat(found, axis=1).round(1).to_string())


LONG = ENTRY | {"name": "long", "role": "contact", "folder": str(FOLDER), "file": "robot.csv"}


def fit(draw: int) -> dict[str, Any]:
    """Return a simulated recording to fit on."""
    plan = {"trajectory": trajectory(draw), "seconds": 40, "seed": draw}
    return ENTRY | {"name": f"fit_{draw}", "role": "fit", "simulate": plan}


def trajectory(draw: int) -> dict[str, Any]:
    """Return a periodic motion of all joints."""
    return {"kind": "fourier", "draw": draw, "period_s": PERIOD, "harmonics": 10}


def study(recordings: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the configuration of the study."""
    return {"study": RESULTS.name, "title": "A long recording", "recordings": recordings}


def periodic_piece(periods: int) -> tuple[bytes, list[bytes]]:
    """Return the header of a simulated CSV, and its rows of some periods without time stamps."""
    begin = REST + PERIOD  # after one period, transients of the start are over
    force = [30.0, -20.0, 40.0]
    pushes = [
        {"kind": "push", "start_s": begin + PERIOD * k + 8, "seconds": 3, "force": force}
        for k in range(periods)
    ]
    plan = SimulatedRecording.model_validate(
        {"trajectory": trajectory(5), "seconds": begin + PERIOD * periods, "contacts": pushes}
    )
    with tempfile.TemporaryDirectory() as folder:
        simulate(
            load_robot(robot_path("ur5e")), plan, "rtde-csv", Path(folder), Path(folder) / "truth"
        )
        header, *rows = (Path(folder) / "robot.csv").read_bytes().splitlines(keepends=True)
    periodic = rows[begin * RATE : (begin + PERIOD * periods) * RATE]
    return header, [row[row.index(b",") :] for row in periodic]


def write_recording(piece: tuple[bytes, list[bytes]], minutes: int) -> None:
    """Write the piece repeatedly, with continuous time stamps."""
    header, rows = piece
    FOLDER.mkdir(parents=True, exist_ok=True)
    with (FOLDER / "robot.csv").open("wb") as file:
        file.write(header)
        for start in range(0, 60 * RATE * minutes, len(rows)):
            file.writelines(
                b"%.3f%b" % ((start + index) / RATE, row) for index, row in enumerate(rows)
            )


def expect_read() -> None:
    """End where the recording was refused, whose steps are then those of an empty one."""
    quality = pd.read_csv(RESULTS / "tables" / "quality.csv")
    stops = quality[(quality["recording"] == LONG["name"]) & (quality["severity"] == "stop")]
    if len(stops):
        sys.exit(str(stops["detail"].iloc[0]))


def steps() -> pd.DataFrame:
    """Return wall time [s], processor time [s] and memory [MB] of the recording's steps."""
    traces = RESULTS / "benchmarks"
    files = {path.parent.name: path for path in traces.glob("*/long.tsv")}
    files |= {path.stem: path for path in traces.glob("*.tsv")}
    table = {step: pd.read_csv(path, sep="\t").iloc[0] for step, path in sorted(files.items())}
    names = {"s": "wall s", "cpu_time": "cpu s", "max_rss": "MB"}
    return pd.DataFrame(table).T.reindex(columns=list(names)).rename(columns=names)


if __name__ == "__main__":
    main()

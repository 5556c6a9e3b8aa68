"""The residual torque of free recordings on the virtual test stand beside that of real arms.

    python -m benchmarks.stand_and_arms [<study> ...] [--page] [--quick]

Takes results/<study> as built, of one arm; the default study, demo, is the stand. A row for each
study: what the torques of its recordings of the roles fit and validate without a load are in error,
each predicted by a fit without its own path, in shares of the joints' breakaway torques.
Moving: of joints that move; resting: of all joints while the whole arm rests; held: mean of a rest,
its standard deviation from stop to stop and the largest; drift: from the first to the last half
second of a rest; run to run: mean along the direction of motion, its standard deviation over
recordings; bands: shares of the power about the mean of ten seconds. Root mean squares over joints.
`--page` writes the section of docs/world.md.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from scipy.signal import welch

from benchmarks.harness.markdown import markdown, read_page, replaced, write_page
from benchmarks.harness.options import built, study_options
from ur5lib.force.external_torque import JointState, joint_states
from ur5lib.identification.currents import breakaway_torque
from ur5lib.records.currents import Currents
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.study.model import Settings
from ur5lib.tables import read_record
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import runs
from ur5lib.timeseries.trajectories import REST_SPEED

RESULTS, PAGE = Path("results"), Path("docs/world.md")
CUTOFF = Settings().lowpass.currents.cutoff_hz
TITLE = "The stand beside real arms"  # of the section
ARMS = {"demo": "the stand", "thesis": "UR5 (thesis)", "ur10e": "UR10e", "ur3-cb": "UR3"}
ARMS |= {"ur5e-rtde": "UR5e"}
STAND = ARMS["demo"]
REST, ENDS = 1.0, 0.5  # s; shortest rest; its first and last part
WINDOW = 10.0  # s, of the spectra
BANDS = (0.0, 0.2), (0.2, 0.7), (0.7, 2.0)  # Hz
LEAST = 1.0  # s; a joint that moves less shows no friction


class Free(NamedTuple):
    """A free recording.

    torque: the residual (N, n), in breakaway torques; direction: (N, n), of moving joints, 0 for
    others; resting: (N,), the whole arm; period: [s].
    """

    torque: Array
    direction: Array
    resting: Mask
    period: float


class Row(NamedTuple):
    """A study's numbers, in shares of breakaway; NaN where its recordings show none."""

    moving: float
    resting: float
    held: float
    largest: float
    drift: float
    run_to_run: float
    slow: float
    middle: float
    fast: float


HEADS = ["arm", "moving", "whole arm at rest", "held, from stop to stop", "held, largest"]
HEADS += ["drift within a rest", "friction, run to run"]
HEADS += [f"power {low:g} to {high:g} Hz" for low, high in BANDS]


def main() -> None:
    """Print the table, and write it."""
    options = study_options(__doc__)
    options.set_defaults(studies=[*ARMS])
    options.add_argument("--page", action="store_true", help="write docs/world.md as well")
    given = options.parse_args()
    folders = [RESULTS / name for name in given.studies]
    if given.quick and given.studies == [*ARMS]:
        folders = [folder for folder in folders if (folder / "configuration.yaml").exists()]
    rows = [[ARMS.get(one.name, one.name), *written(row_of(one))] for one in built(folders)]
    found = markdown(HEADS, rows)
    print(found)
    if given.page:
        write_page(replaced(read_page(PAGE), TITLE, found), PAGE)


def written(row: Row) -> list[str]:
    """Return the numbers as the page writes them."""
    return ["–" if np.isnan(number) else f"{number:.2g}" for number in row]


def row_of(folder: Path) -> Row:
    """Return the numbers of a built study with one arm."""
    free = [*free_recordings(folder)]
    moving = [one.torque[one.direction != 0] for one in free]
    held, drift = rests(free)
    return Row(
        moving=rms(np.concatenate(moving)),
        resting=rms(np.concatenate([one.torque[one.resting] for one in free])),
        held=rms(spread(held)),
        largest=float(np.abs(held).max(initial=0.0)) if len(held) else np.nan,
        drift=rms(drift),
        run_to_run=rms(spread(np.array([along_motion(one) for one in free]))),
        **dict(zip(("slow", "middle", "fast"), power_shares(free), strict=True)),
    )


def free_recordings(folder: Path) -> Iterator[Free]:
    """Yield the recordings of a built study without contact and without a load."""
    study = yaml.safe_load((folder / "configuration.yaml").read_text(encoding="utf-8"))
    [arm] = (folder / "parameters").iterdir()
    breakaway = breakaway_torque(read_record(Friction, str(arm / "friction.json")).fit)
    for entry in study["recordings"]:
        at = folder / "recordings" / entry["name"]
        if entry["role"] == "contact":
            continue
        currents = Currents.read(at / "currents.parquet")
        if currents.external_torque is None or carries(currents):
            continue
        motion = Motion.read(at / "motion.parquet")
        states = joint_states(motion.motor_qd, motion.segment, motion.period, CUTOFF)
        moves = (states == JointState.MOVING) & np.isfinite(currents.external_torque)
        yield Free(
            torque=currents.external_torque / breakaway,
            direction=np.sign(motion.motor_qd) * moves,
            resting=np.asarray((np.abs(motion.motor_qd) < REST_SPEED).all(axis=1)),
            period=motion.period,
        )


def carries(currents: Currents) -> bool:
    """Return whether a load was estimated."""
    return currents.load_doubt is not None and bool(np.nan_to_num(currents.load_doubt).any())


def rests(free: list[Free]) -> tuple[Array, Array]:
    """Return mean and drift (R, n) of each rest of the whole arm."""
    means, drifts = [], []
    for one in free:
        for first, last in runs(one.resting & np.isfinite(one.torque).all(axis=1)):
            rest, end = one.torque[first:last], round(ENDS / one.period)
            if len(rest) * one.period > REST:
                means.append(rest.mean(axis=0))
                drifts.append(rest[-end:].mean(axis=0) - rest[:end].mean(axis=0))
    return np.array(means), np.array(drifts)


def along_motion(one: Free) -> Array:
    """Return the mean torque (n,) along the direction of motion; NaN of a joint that rests."""
    moves = one.direction != 0
    total = np.where(moves, one.torque * one.direction, 0.0).sum(axis=0)
    samples = moves.sum(axis=0)
    return np.where(samples * one.period > LEAST, total / np.maximum(samples, 1), np.nan)


def spread(values: Array) -> Array:
    """Return the standard deviation (n,) of values (R, n), NaN of fewer than two."""
    if len(values) < 2:
        return np.full(values.shape[1:], np.nan)
    enough = np.isfinite(values).sum(axis=0) > 1
    return np.asarray(np.nanstd(values[:, enough], axis=0, ddof=1))


def power_shares(free: list[Free]) -> list[float]:
    """Return the shares of the residual torque's power in BANDS."""
    total = np.zeros(len(BANDS))
    for one in free:
        length = min(round(WINDOW / one.period), len(one.torque))
        torque = np.nan_to_num(one.torque)
        frequency, power = welch(torque, 1 / one.period, nperseg=length, axis=0)
        power = len(torque) * power.sum(axis=1)
        total += [power[(low <= frequency) & (frequency < high)].sum() for low, high in BANDS]
    return [float(share) for share in total / total.sum()]


def rms(values: Array) -> float:
    """Return the root mean square of the known ones, NaN without any."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else np.nan


if __name__ == "__main__":
    main()

"""Forces in contact where friction is fitted to one, two or three paths.

    python -m benchmarks.few_recordings [<study> [<robot>]] [--draws 20] [--quick]

Takes results/<study> as built; by default that of `make`, of a ur5. So many subsets of one, two and
three paths of the recordings to fit on are drawn with a seed, after all of them. Friction, residual
model and threshold come from one subset at a time, by the workflow's own steps, and the forces of
the recordings with a force sensor from these. A line each: the share of the samples in contact
within the 95 % band of F̂ᵐᵃᵖ, over all axes and recordings; half of this band, at the median; how
many contacts of the sensor are found, where the arm rests and where it moves. The rigid-body model
stays the study's: the controller's own torque tells it, not the currents.
"""

import tempfile
from collections.abc import Sequence
from itertools import chain, combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch

from benchmarks.harness.options import arm_options, built
from benchmarks.leave_out import Fold, Recording, Study, read_study, refusal
from ur5lib.force.detection import alarms, compare, contacts, in_contact
from ur5lib.force.external_torque import REST_SPEED
from ur5lib.records.forces import Forces, SensorWrenches
from ur5lib.records.motion import Motion
from ur5lib.tables import read_json
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import NORMAL95

MOST_PATHS = 3
SEED = 0


class Result(NamedTuple):
    """Of one recording: in contact, what is inside the band (n, 3), and half the band (n, 3) [N];
    whether the arm rests; contacts of the sensor, and those found.
    """

    inside: Mask
    half: Array
    rests: bool
    contacts: int
    found: int


def main() -> None:
    """Print a line for each subset."""
    options = arm_options(__doc__)
    options.add_argument("--draws", type=int, default=20, help="subsets that are drawn")
    given = options.parse_args()
    [folder] = built([Path("results") / given.study])
    torch.set_num_threads(1)
    study = read_study(folder, given.robot, ("fit", "contact"))
    drawn = [study.fit, *subsets(study, given.draws)]
    for fitted in drawn[-1:] if given.quick else drawn:
        print(f"{', '.join(own.name for own in fitted)}\n    {judged(study, fitted)}", flush=True)


def subsets(study: Study, draws: int) -> list[list[Recording]]:
    """Recordings of one to MOST_PATHS paths, each subset once; at most so many, by chance."""
    paths = sorted({own.path for own in study.fit})
    sizes = range(1, min(MOST_PATHS, len(paths) - 1) + 1)
    every = [*chain.from_iterable(combinations(paths, size) for size in sizes)]
    chosen = np.random.default_rng(SEED).permutation(len(every))[:draws]
    return [[own for own in study.fit if own.path in every[one]] for one in sorted(chosen)]


def judged(study: Study, fitted: list[Recording]) -> str:
    """What a fit tells of the recordings along other paths in which a sensor felt contacts."""
    seen = {own.path for own in fitted}
    touched = [own for own in touched_of(study) if own.path not in seen]
    with tempfile.TemporaryDirectory() as folder:
        fold = Fold(study, fitted, Path(folder))
        if why := refusal(fold, touched):
            return f"no forces: {why}"
        fold.estimate(touched)
        return told([result(fold, own) for own in touched])


def sensed(own: Recording) -> Array:
    """The sensor's wrench (N, 6), bias and tool removed; empty without a sensor."""
    found = SensorWrenches.read(own.file("sensor.parquet")).wrench
    return found.get("compensated", np.empty((0, 6)))


def touched_of(study: Study) -> list[Recording]:
    """The recordings with contacts that a force sensor felt."""
    contacts = (own for own in study.recordings if own.entry["role"] == "contact")
    return [own for own in contacts if len(sensed(own))]


def in_contact_of(fold: Fold, own: Recording) -> tuple[Array, Array, Array]:
    """Of what a fold tells in contact: absolute errors, half bands and forces, (n, 3) [N] each."""
    forces, true = Forces.read(fold.own(own, "forces.parquet")), sensed(own)[:, :3]
    force, half = forces.wrench["Fmap"][:, :3], NORMAL95 * forces.std["Fmap"][:, :3]
    during = in_contact(np.linalg.norm(true, axis=1)) & np.isfinite(force).all(axis=1)
    return np.abs(force - true)[during], half[during], true[during]


def result(fold: Fold, own: Recording) -> Result:
    """What a fold tells of one recording."""
    error, half, _ = in_contact_of(fold, own)
    forces = Forces.read(fold.own(own, "forces.parquet"))
    raised = alarms(forces.log_odds["Fmap"], read_json(fold.shared("threshold.json"))["Fmap"])
    size = np.linalg.norm(sensed(own)[:, :3], axis=1)
    matched = compare(raised, contacts(size), forces.period)
    rests = bool(np.nanmax(np.abs(Motion.read(own.file("motion.parquet")).qd)) < REST_SPEED)
    return Result(error <= half, half, rests, matched.contacts, matched.found)


def told(results: Sequence[Result]) -> str:
    """All recordings in one line."""
    inside, half = (
        np.concatenate([getattr(own, n) for own in results]) for n in ("inside", "half")
    )
    counts = [
        f"{sum(own.found for own in part)} of {sum(own.contacts for own in part)} {where}"
        for where, rests in (("at rest", True), ("in motion", False))
        if (part := [own for own in results if own.rests == rests])
    ]
    widths = ", ".join(f"{width:.0f}" for width in np.median(half, axis=0))
    return f"inside {inside.mean():.2f}, ± {widths} N; found {', '.join(counts)}"


if __name__ == "__main__":
    main()

"""What comes back from the virtual test stand, seed by seed, and how often its intervals hold.

Three recordings to fit are simulated for each seed, and one that is pushed; motion, posture and
all noise are drawn anew, and files are read as real ones are. Counted are, for each quantity, the
values whose stated 95 % interval holds the truth, and the largest error; of the contact wrench the
share inside its 95 % band and the error, beside that of an estimate of zero, over whole recordings
and while in contact.
"""

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pandas as pd
import torch

from benchmarks.harness.options import asked
from benchmarks.harness.stand import (
    SECONDS,
    Taken,
    currents,
    fitted_map,
    plans,
    residuals_of,
    rotors,
    taken,
)
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.problem import fmap_problem
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.forces import Forces
from ur5lib.records.friction import Friction
from ur5lib.signals.imu_calibration import calibrate_without_each
from ur5lib.timeseries.arrays import Mask
from ur5lib.topics.truth.beside import (
    Row,
    clock_rows,
    friction_rows,
    imu_rows,
    rotor_rows,
    wrench_rows,
)

SEEDS = 20


def main() -> None:
    """Print the number of intervals with the truth, and the share of the wrench in its band."""
    seeds, quick = asked(__doc__, SEEDS)
    length = 5.0 if quick else SECONDS
    torch.set_num_threads(1)
    rows = pd.DataFrame([row for seed in range(seeds) for row in recovered(seed, length)])
    print(f"{seeds} seeds, 3 recordings to fit of {length:g} s each and a pushed one")
    for quantity, part in rows.groupby("quantity", sort=False):
        off = (part["estimate"] - part["truth"]).abs()
        if part["within95"].notna().all():
            inside = part["within95"] == "yes"
            print(
                f"{quantity:>28}: {inside.sum():>4} of {len(part):>4} intervals hold the truth "
                f"({inside.mean():.0%}), largest error {off.max():.2g} {part['unit'].iloc[0]}"
            )
    wrench = rows[rows["quantity"].str.contains("coverage|rmse")]
    mean = wrench.pivot_table(["estimate", "zero"], ["quantity", "index"], sort=False)
    print(mean.to_string(float_format="%.3g"))


def recovered(seed: int, seconds: float = SECONDS) -> Iterator[Row]:
    """Yield rows of all estimates and the truth, from the recordings of one seed."""
    with tempfile.TemporaryDirectory() as folder:
        drawn = enumerate(plans(seed, seconds))
        *fitted, pushed = (taken(plan, Path(folder, str(k))) for k, plan in drawn)
        yield from device_rows(fitted)
        friction, truth = fitted_map(fitted), fitted[0].summary
        yield from friction_rows(friction, truth.drive, truth.friction)
        yield from pushed_rows(friction, fitted, pushed)


def device_rows(fitted: list[Taken]) -> Iterator[Row]:
    """Rows of clocks, rotor inertias and the IMU."""
    robot, summary = fitted[0].robot, fitted[0].summary
    for own in fitted:
        yield from clock_rows({"imu": own.clock}, own.summary)
    true = robot.models[summary.model].rotor_inertias
    yield from rotor_rows(rotors(fitted), true)
    calibration = calibrate_without_each({own.record.name: own.imu for own in fitted})["all"]
    assert summary.plan.imu is not None
    yield from imu_rows(calibration, summary.plan.imu)


def pushed_rows(friction: Friction, free: list[Taken], pushed: Taken) -> Iterator[Row]:
    """Yield rows of F^map and the truth, over a whole recording and over its contacts."""
    residuals = residuals_of(friction, free)
    fmap = fmap_problem(pushed.motion, currents(friction, pushed), residuals)
    assert fmap is not None
    prior = ContactPrior.of(pushed.robot, None, ContactPlace())
    estimate = fmap.solve(pushed.kinematics.jacobian[fmap.rows], prior)
    forces = Forces.of(pushed.motion, {"Fmap": estimate}, None)
    true = pushed.truth.at(pushed.signals.time)
    touched = (true.wrench != 0).any(axis=1)
    for rows, when in ((touched | True, ""), (touched, "_in_contact")):
        for row in wrench_rows(part(forces, rows), replace(true, wrench=true.wrench[rows])):
            if row["method"] == "Fmap":
                yield row | {"quantity": f"{row['quantity']}{when}"}


def part(forces: Forces, rows: Mask) -> Forces:
    """The wrenches at some samples."""
    wrench = {name: values[rows] for name, values in forces.wrench.items()}
    return replace(forces, wrench=wrench, std={k: v[rows] for k, v in forces.std.items()})


if __name__ == "__main__":
    main()

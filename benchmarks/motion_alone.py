"""Currents and torques of held-back motions without measured ones: a part of docs/benchmark.md.

    python -m benchmarks.motion_alone [<study> …] [--page]

Fits each study of workflow/studies, by default `thesis`, `ur10e` and `kuka-kr300`, in memory, and
asks `Model.current`, or `torque` of an arm that measures torques, for its recordings of the role
`validate`, from which all efforts are taken away first; `Model.predict` has them. A recording with
an undeclared load, which only currents tell, is left out. Below the low-pass of the fit, NRMSE is
the RMSE over the standard deviation, mean over joints, and the share that of samples in the 95 %
band; "differ by" is the largest difference from `predict`, not low-passed. `--page` writes the
part; `--quick` takes one recording to fit, and one to judge.
"""

from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

import ur5lib
from benchmarks.harness.markdown import markdown, read_page, replaced, write_page
from benchmarks.harness.options import options_of
from ur5lib.channels import EFFORT_CHANNELS
from ur5lib.jobs.memory import record_of
from ur5lib.records.prediction import Prediction
from ur5lib.tables import read_table, read_units, write_table
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import by_segment, period, without_ends

PAGE = Path(__file__).parents[1] / "docs" / "benchmark.md"
TITLE = "Currents from motion alone"
STUDIES = ["thesis", "ur10e", "kuka-kr300"]
CAUSES = ("actual_current", "target_current", "actual_torque", "target_moment", *EFFORT_CHANNELS)
HEAD = ["study", "held back", "NRMSE", "by `predict`", "differ by", "in the 95 % band", "by joint"]


class Judged(NamedTuple):
    """Held-back motions, (N, n) each: efforts found without measured ones, and by `predict`; these
    and the measured ones below the low-pass of the fit, NaN at ends; half: of the 95 % band.
    """

    found: Array
    predicted: Array
    slow_measured: Array
    slow_found: Array
    slow_predicted: Array
    half: Array


def main() -> None:
    """Fit, ask, print and write."""
    options = options_of(__doc__)
    options.add_argument("studies", nargs="*", default=STUDIES, help="of workflow/studies")
    options.add_argument("--page", action="store_true", help="write docs/benchmark.md as well")
    given = options.parse_args()
    rows = []
    for study in given.studies:
        runs = ur5lib.read(f"workflow/studies/{study}.yaml")
        fitted, tested = runs.fit, runs.validate
        if given.quick:
            fitted, tested = fitted[0], tested[0]
        model = ur5lib.fit(fitted)
        kept = unloaded(model, tested)
        rows.append(line(study, kept, judged(model, kept)))
    text = markdown(HEAD, rows)
    print(text)
    if given.page:
        write_page(replaced(read_page(PAGE), TITLE, text), PAGE)


def unloaded(model: ur5lib.Model, runs: ur5lib.Recordings) -> ur5lib.Recordings:
    """Return the recordings that carry no undeclared load."""
    files = model._predicted(runs, None).items()
    return runs[
        [name for name, own in files if not record_of(Prediction, own["prediction"]).is_loaded]
    ]


def judged(model: ur5lib.Model, runs: ur5lib.Recordings) -> Judged:
    """Return the efforts of recordings."""
    effort = model._friction.measured
    ask = getattr(model, effort.quantity)
    found, std = ask(without_efforts(runs), return_std=True)
    frame = model.predict(runs)
    measured, predicted = (
        frame.filter(regex=rf"^{of}_{effort.quantity}_\d+$").to_numpy()
        for of in ("actual", "predicted")
    )
    slow, slow_found, slow_predicted = (
        lowpassed(model, runs, own) for own in (measured, found, predicted)
    )
    return Judged(found, predicted, slow, slow_found, slow_predicted, NORMAL95 * std)


def lowpassed(model: ur5lib.Model, runs: ur5lib.Recordings, values: Array) -> Array:
    """Return values (N, n) of recordings below the low-pass of the fit, NaN where that
    extrapolates.
    """
    lowpass, parts, start = model._lowpass(), list[Array](), 0
    for own in runs._files.values():
        table = read_table(own["robot"], ["time", "segment"])
        segment, step = table["segment"].to_numpy(), period(table["time"].to_numpy())
        part = values[start : start + len(table)]
        slow = by_segment(zero_phase_lowpass, part, segment, 1 / step, *lowpass)
        parts.append(without_ends(slow, segment, step, lowpass.cutoff))
        start += len(table)
    return np.concatenate(parts)


def without_efforts(runs: ur5lib.Recordings) -> ur5lib.Recordings:
    """Return recordings of which only the motion was recorded."""
    files = {}
    for name, own in runs._files.items():
        table, units = read_table(own["robot"]), read_units(own["robot"])
        kept = [column for column in table if not str(column).startswith(CAUSES)]
        write_table(table[kept], content := BytesIO(), {column: units[column] for column in kept})
        files[name] = own | {"robot": content}
    return ur5lib.Recordings(runs._study, runs._arm, files, runs._qualities)


def line(study: str, runs: ur5lib.Recordings, own: Judged) -> list[str]:
    """Return a line of the table."""
    found, predicted = (
        mean_nrmse(own.slow_measured, by) for by in (own.slow_found, own.slow_predicted)
    )
    differ = np.abs(own.found - own.predicted).max()
    error = np.abs(own.slow_measured - own.slow_found)
    shares = np.nanmean(np.where(np.isfinite(error), error <= own.half, np.nan), axis=0)
    joints = ", ".join(f"{share:.3f}" for share in shares)
    cells = [f"{found:.3f}", f"{predicted:.3f}", f"{differ:.1g}", f"{shares.mean():.3f}", joints]
    return [study, str(len(runs)), *cells]


def mean_nrmse(measured: Array, found: Array) -> float:
    """Return the RMSE of each joint over its standard deviation, mean over joints."""
    rmse = np.sqrt(np.nanmean((measured - found) ** 2, axis=0))
    return float((rmse / np.nanstd(measured, axis=0)).mean())


if __name__ == "__main__":
    main()

"""Friction and rotors of a Stäubli TX40 beside published ones: a part of docs/benchmark.md.

    python -m benchmarks.published_friction [--folder raw/staubli-tx40] [--page]

Fits 9 s of motor positions and torques at 5 kHz (pos_read_data.csv, curr_data.csv of FIGAROH's
example) with the terms of Gautier, Janot and Vandanjon 2013: Coulomb and viscous friction, offset
and rotor of each joint, and those of the motor that turns with joints 5 and 6. `--page` writes it.
"""

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from benchmarks.harness.markdown import markdown, read_page, replaced, wrapped, write_page
from benchmarks.harness.options import options_of
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.identification.base_parameters import InertialEstimate
from ur5lib.identification.current_samples import ZeroPhaseLowpass, measured_samples
from ur5lib.identification.measured_torques import ArmFit
from ur5lib.identification.torque_rows import MeasuredRun, torque_rows
from ur5lib.recordings.counting import at_the_joints
from ur5lib.recordings.intake import with_efforts
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot, load_robot
from ur5lib.robots.drives import shaft_matrix
from ur5lib.smoothing.encoders import smooth_encoders
from ur5lib.smoothing.smoothed_motion import measured, motion_record
from ur5lib.tables import named
from ur5lib.timeseries.arrays import Array

PAGE = Path(__file__).parents[1] / "docs" / "benchmark.md"
TITLE = "Friction beside published values"
ARM = Path(__file__).parent / "harness" / "staubli-tx40.yaml"
FILES = ("pos_read_data.csv", "curr_data.csv")
RATE, MEAN_OF = 5000.0, 5  # Hz, 1; rate, and number of samples averaged
SMOOTH = ZeroPhaseLowpass(4, 10.0)
QUICK_SECONDS = 4
PUBLISHED = {  # as TX40_config.yaml repeats them, by joint
    "viscous": (8.05, 5.53, 1.97, 1.11, 1.86, 0.65),
    "coulomb": (7.14, 8.26, 6.34, 2.48, 3.03, 0.282),
    "rotor": (0.362, 0.362, 0.0988, 0.0313, 0.0468, 0.0105),
    "offset": (0.392, 1.37, 0.326, -0.102, -0.0288, 0.127),
}
PUBLISHED_OF_SHAFT = {"viscous": 0.616, "coulomb": 1.95, "rotor": 0.00964}
BASE_TERMS = ("coulomb", "viscous")
UNITS = {"viscous": "Nm s/rad", "coulomb": "Nm", "rotor": "kg m²", "offset": "Nm"}
SHARED = ("viscous", "rotor")  # published values of joints 5 and 6 include those of the shaft


class Value(NamedTuple):
    """One value, the half-width of its 95 % interval, and the published value."""

    what: str
    quantity: str
    value: float
    half: float
    published: float

    def row(self) -> list[str]:
        """Return the row of a table."""
        held = abs(self.published - self.value) <= self.half
        numbers = f"{self.value:.3g} ± {self.half:.2g}", f"{self.published:.3g}"
        return [
            self.what,
            f"{self.quantity} [{UNITS[self.quantity]}]",
            *numbers,
            "yes" if held else "no",
        ]


def main() -> None:
    """Fit, print and write."""
    options = options_of(__doc__)
    options.add_argument("--folder", type=Path, default=Path("raw/staubli-tx40"))
    options.add_argument("--page", action="store_true", help="write docs/benchmark.md as well")
    given = options.parse_args()
    if not all((given.folder / file).exists() for file in FILES):
        sys.exit(f"{given.folder} lacks {' or '.join(FILES)}: put FIGAROH's files there")
    arm = load_robot(ARM)
    run = recorded(arm, given.folder, QUICK_SECONDS if given.quick else None)
    fit, places = fitted(arm, run, coupled=True)
    values = [*compared(fit.estimate(places), places, fit)]
    header = ["of", "value", "ours, 95 %", "published", "inside"]
    text = markdown(header, [value.row() for value in values])
    residuals = [*wrist_residuals(arm, run)]
    print(text, *residuals, sep="\n")
    if given.page:
        page = replaced(read_page(PAGE), TITLE, text)
        write_page(with_residuals(page, residuals), PAGE)


def with_residuals(page: str, sentences: Sequence[str]) -> str:
    """Return the page with these sentences below the table, in place of an earlier run's."""
    start = page.index(sentences[0].strip().partition(",")[0])
    end = page.index("\n\n", start)
    told = " ".join(one.strip() for one in sentences)
    return page[:start] + wrapped(told) + page[end:]


def recorded(arm: Robot, folder: Path, seconds: float | None) -> MeasuredRun:
    """Return the motion and the torques of the joints, from those of the motors."""
    q, torque = (pd.read_csv(folder / file).to_numpy(float) for file in FILES)
    count = len(q) // MEAN_OF if seconds is None else int(seconds * RATE / MEAN_OF)
    mean_q, mean_torque = (
        own[: count * MEAN_OF].reshape(count, MEAN_OF, -1).mean(axis=1) for own in (q, torque)
    )
    channels = named(mean_q, "actual_q") | named(mean_torque, "actual_torque")
    time = np.arange(count) * MEAN_OF / RATE
    table = pd.DataFrame({"time": time, "segment": 0, "interpolated": False, **channels})
    signals = Signals.from_table(with_efforts(at_the_joints(table, arm), arm, []))
    motion = smooth_encoders(signals.time, signals.segment, *measured(signals))
    moved = motion_record(signals, motion)
    samples = measured_samples("tx40", signals, moved, arm, 0 * moved.q)
    assert samples is not None
    return MeasuredRun(samples, moved.qdd, LinkModel(arm, arm.chosen_model).regressor)


def fitted(arm: Robot, run: MeasuredRun, coupled: bool) -> tuple[ArmFit, list[int]]:
    """Return the fit of the arm with or without the coupled motor, and its columns."""
    rows = torque_rows([run], [*BASE_TERMS, "coupled"], SMOOTH, shaft_matrix(arm))
    terms = [*BASE_TERMS, *(["coupled"] * coupled)]
    return ArmFit(arm, rows, terms), rows.places(terms)


def compared(estimate: InertialEstimate, places: Sequence[int], fit: ArmFit) -> Iterator[Value]:
    """Yield our values and the published ones, with the publication's definitions."""
    names = fit.rows.coefficients()
    first = fit.size

    def place(joint: int, name: str) -> int:
        if name == "rotor":
            return fit.size - fit.rows.joints + joint - 1
        return places.index(first + len(names) * (joint - 1) + names.index(name))

    shaft, *_ = fit.rows.motors
    for quantity, published in PUBLISHED.items():
        for joint, value in enumerate(published, 1):
            group = np.zeros(len(places))
            group[place(joint, quantity)] = 1
            if joint >= shaft - 1 and quantity in SHARED:
                group[place(shaft, f"coupled_{quantity}")] = 1
            yield Value(f"joint {joint}", quantity, *interval(estimate, group), value)
    for quantity, value in PUBLISHED_OF_SHAFT.items():
        group = np.zeros(len(places))
        group[place(shaft, f"coupled_{quantity}")] = 1
        yield Value("shaft of joints 5 and 6", quantity, *interval(estimate, group), value)


def interval(estimate: InertialEstimate, group: Array) -> tuple[float, float]:
    """Return a sum of parameters, and half its 95 % interval by Student's t over the units."""
    units = len(estimate.scatter) - len(estimate.parameters)
    error = estimate.standard_errors(group[None])[0]
    return float(group @ estimate.parameters), float(stdtrit(units - 1, 0.975) * error)


def wrist_residuals(arm: Robot, run: MeasuredRun) -> Iterator[str]:
    """Yield the correlation of joint 5's residual with joint 6's velocity, with and without the
    coupled motor.
    """
    for words, coupled in (("Without the shared shaft", False), ("With it", True)):
        fit, places = fitted(arm, run, coupled)
        value, velocity = fit.estimate(places).parameters, run.samples.qd[:, 5]
        pairs = [(Y[:, 4][:, places] @ value, torque[:, 4]) for Y, torque in fit.rows.units]
        residual = np.concatenate([torque - predicted for predicted, torque in pairs])
        spread = np.linspace(0, len(velocity) - 1, len(residual)).round().astype(int)
        correlation = np.corrcoef(residual, velocity[spread])[0, 1]
        size = np.sqrt(np.mean(residual**2))
        yield (
            f"{words}, the residual of joint 5 is {size:.2f} Nm (RMS), and its correlation with "
            f"the velocity of joint 6 is {correlation:+.2f}.\n"
        )


if __name__ == "__main__":
    main()

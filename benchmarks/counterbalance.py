"""Whether a counterbalance is found on arms that have none, and on one that has.

    python -m benchmarks.counterbalance [<study> ...]

Identifies the arms of results/<study> from currents times their torque constants, or from measured
torques, as arms whose links are unknown. Prints by joint the squared error on units left out with
bodies, over that with any inertial parameters, and the joints whose gravity only a counterbalance
explains. `--quick` takes few recordings.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.harness.markdown import markdown
from benchmarks.harness.options import built, study_options
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import RefusalError
from ur5lib.finished import StudyFiles
from ur5lib.identification.current_samples import ZeroPhaseLowpass, measured_samples
from ur5lib.identification.measured_torques import JOINT_TERMS, ArmFit
from ur5lib.identification.torque_rows import MeasuredRun, torque_rows
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.robots.drives import shaft_matrix

RESULTS, SMOOTH = Path("results"), ZeroPhaseLowpass(4, 2.0)
QUICK_RECORDINGS = 6
# kg, with the base, from data sheets; for other arms, the description's weight or sum of the links
WEIGHTS = {"ur3": 11.0, "ur5": 18.4, "ur10": 28.9, "ur3e": 11.2, "ur5e": 20.6, "ur10e": 33.5}


def main() -> None:
    """Fit and print."""
    given = study_options(__doc__).parse_args()
    folders = built(RESULTS / name for name in given.studies)
    most = QUICK_RECORDINGS if given.quick else sys.maxsize
    lines = [line for folder in folders for line in of_study(StudyFiles(folder), most)]
    header = [
        "study",
        "arm",
        "recordings",
        "error with bodies over any, by joint",
        "found on",
    ]
    print(markdown(header, lines))


def of_study(study: StudyFiles, most: int) -> Iterator[list[str]]:
    """Yield the rows of a study's arms; most: number of fit recordings of each arm."""
    for folder in sorted((study.folder / "parameters").iterdir()):
        arm, name = study.arm(folder.name), folder.name
        names = study.parameters(Friction, name, "friction").from_[:most]
        weight = WEIGHTS.get(name) or arm.weight or sum(arm.masses)
        try:
            found = of_arm(arm.model_copy(update={"weight": weight}), study, names)
        except (RefusalError, ValueError) as error:
            found = ["0", f"nothing told ({error})", ""]
        yield [study.folder.name, name, *found]


def of_arm(arm: Robot, study: StudyFiles, names: list[str]) -> list[str]:
    """Return the number of an arm's recordings, the ratios of errors, and the balanced joints."""
    runs = [run for name in names for run in runs_of(arm, study, name)]
    rows = torque_rows(runs, JOINT_TERMS, SMOOTH, shaft_matrix(arm))
    fit, places = ArmFit(arm, rows, JOINT_TERMS), rows.places(JOINT_TERMS)
    any_links, bodies = (fit.unseen_errors(places, own) for own in (None, fit.bounds))
    ratios = bodies.sum(axis=0) / any_links.sum(axis=0)
    found = fit.balanced_joints(JOINT_TERMS)
    text = ", ".join(f"{ratio:.3f}" for ratio in ratios)
    return [str(len(runs)), text, ", ".join(map(str, found)) or "none"]


def runs_of(arm: Robot, study: StudyFiles, name: str) -> Iterator[MeasuredRun]:
    """Yield a recording with torques in place of currents, if it moves."""
    signals, motion = study.record(Signals, name), study.record(Motion, name)
    samples = measured_samples(name, signals, motion, arm, 0 * motion.q)
    if samples is not None and (np.abs(motion.motor_qd) > 0.05).mean() > 0.1:
        torque = samples.current * np.array(arm.maker_torque_constants())
        gravity = study.recording(name).known_gravity()
        model = LinkModel(arm.mounted(gravity), arm.chosen_model)
        yield MeasuredRun(replace(samples, current=torque), motion.qdd, model.regressor)


if __name__ == "__main__":
    main()

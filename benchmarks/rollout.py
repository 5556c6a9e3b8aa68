"""Exported arms in MuJoCo under recorded efforts, beside this project's own simulation of them.

Over windows of recordings that no fit has seen, of each arm of built studies: how far the flange of
each is from where it went, and from our simulation of the same links and the two terms of friction
that a simulator has. `mjcf` and `urdf` are what `ur5 export` writes; a URDF has no rotors, which
`urdf, rotors` sets as its comment says.
"""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import mujoco
import numpy as np

from benchmarks.harness.options import built, study_options
from ur5lib.commands.exported import exported, simulator_friction
from ur5lib.dynamics.many_arms import ManyArms
from ur5lib.finished import StudyFiles
from ur5lib.identification.currents import motor_torque
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.rollout.errors import deviations, median_interval, sizes
from ur5lib.topics.rollout.models import IDENTIFIED, contenders
from ur5lib.topics.rollout.roll_out import Inputs, Run, rolled, runs_of, windows_of
from ur5lib.topics.rollout.simulation import STEP, ManyFrictions, simulated
from ur5lib.topics.rollout.windows import ENDS, HORIZONS, Windows
from ur5rivals.replay import DISABLED_FLAGS, read_model

PARTS = 5  # of a step in MuJoCo
AT_ONCE = 1e-6  # rad; Coulomb friction of simulators reverses over no distance
SHOWN = [HORIZONS.index(horizon) for horizon in (0.1, 0.5, 2.0)]
KINDS = (  # format, whether rotors are set, and whether friction is as hard as steps allow
    ("mjcf", False, False),
    ("mjcf", False, True),
    ("urdf", False, False),
    ("urdf", True, False),
)
OWN_COPY = "our simulation of the export"


def main() -> None:
    """Print a table for each arm: by model, the median error at the flange [mm] after each time
    with its 95 % interval, and the median distance from our simulation over the way.
    """
    given = study_options(__doc__).parse_args()
    for folder in built(Path("results") / name for name in given.studies):
        study = StudyFiles(folder)
        for robot in study.configuration().arms():
            report(study, robot, folder, 6 if given.quick else 100)


def report(study: StudyFiles, robot: str, folder: Path, most: int) -> None:
    """Print the table of an arm; most: number of windows."""
    arm, friction = study.arm(robot), study.parameters(Friction, robot, "friction")
    entries = [
        one
        for one in study.configuration().recordings
        if one.arm.known_as == robot and one.role == "validate" and one.name not in friction.from_
    ]
    inputs = {
        one.name: Inputs(
            signals=study.record(Signals, one.name),
            motion=study.record(Motion, one.name),
            premises=study.record(Premises, one.name),
            prediction=study.record(Prediction, one.name, "currents"),
            quality=study.quality(one.name),
        )
        for one in entries
    }
    gravities = {one.name: [*(one.known_gravity() or ())] or None for one in entries}
    runs = runs_of(arm, inputs, friction, gravities)
    windows = windows_of(runs)
    if windows is None:
        print(f"{folder.name}, {robot}: too few windows that no fit has seen")
        return
    windows = windows.at(
        np.linspace(0, len(windows.row) - 1, min(most, len(windows.row))).astype(int)
    )
    print(f"{folder.name}, {robot}: {len(windows.row)} windows")
    print(
        f"{'':28}"
        + "".join(f"{f'after {HORIZONS[k]:g} s [mm]':>26}" for k in SHOWN)
        + "    of the way"
    )
    found = dict(simulations(study, robot, folder, runs, windows, friction))
    way = np.linalg.norm(
        deviations(arm, windows.q[:, None], windows.reached[:, -1:])[:, 0, -3:], axis=1
    )
    ours = found[OWN_COPY]
    for name, angles in found.items():
        off = sizes(deviations(arm, angles, windows.reached))[..., -1]
        low, high = median_interval(off)
        apart = sizes(deviations(arm, angles, ours))[:, -1, -1]
        cells = (f"{np.median(off[:, k]):.1f} ({low[k]:.1f} to {high[k]:.1f})" for k in SHOWN)
        print(
            f"{name:28}"
            + "".join(f"{cell:>26}" for cell in cells)
            + f"{np.median(apart / way):>14.2%}"
        )


def simulations(
    study: StudyFiles,
    robot: str,
    folder: Path,
    runs: list[Run],
    windows: Windows,
    friction: Friction,
) -> Iterator[tuple[str, Array]]:
    """Yield the angles (W, H, n) of each model after each of HORIZONS."""
    first, *_ = contenders(study.arm(robot), friction)
    torque = motor_torque(friction.fit, windows.effort)
    yield IDENTIFIED, rolled([(first, windows)], runs, friction)[0]
    written = simulator_friction(robot, first.links, study)
    assert written is not None
    pair = np.nan_to_num(np.column_stack([written.coulomb, written.viscous]))
    copies = ManyFrictions(
        ("coulomb", "viscous"),
        np.tile(pair, (len(windows.row), 1, 1)),
        np.zeros(len(pair)),
        AT_ONCE,
    )
    arms = ManyArms([(run.arm, first.links) for run in runs], windows.recording)
    yield OWN_COPY, simulated(arms, copies, windows.start, torque)[:, ENDS - 1]
    for kind, rotors, hard in KINDS:
        with TemporaryDirectory() as temporary:
            engines = [
                engine_of(Path(temporary) / f"{k}.xml", kind, run, folder, robot)
                for k, run in enumerate(runs)
            ]
        if rotors:
            for engine, run in zip(engines, runs, strict=True):
                engine.dof_armature[:] = rigid_bodies(run.arm, first.links).rotor_inertia
                mujoco.mj_setConst(engine, mujoco.MjData(engine))  # else friction is soft
        if hard:
            for engine in engines:
                engine.dof_solref[:, 0] = 2 * engine.opt.timestep
        name = kind + (", rotors" if rotors else "") + (", hard friction" if hard else "")
        yield (
            name,
            np.array(
                [
                    by_mujoco(engines[k], windows, row, torque[row])
                    for row, k in enumerate(windows.recording)
                ]
            ),
        )


def engine_of(file: Path, kind: str, run: Run, folder: Path, robot: str) -> mujoco.MjModel:
    """Return an arm, as `ur5 export` writes it for a recording, in MuJoCo."""
    name = run.samples.name
    file.write_text(exported(robot, None, kind, folder, name, accept="a benchmark"))
    engine = read_model(file, np.array(run.arm.gravity), run.samples.q.shape[1])
    engine.opt.disableflags |= DISABLED_FLAGS
    engine.opt.timestep = STEP / PARTS
    engine.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return engine


def by_mujoco(engine: mujoco.MjModel, windows: Windows, row: int, torque: Array) -> Array:
    """Return the angles (H, n) after each of HORIZONS; torque: (STEPS, n) of a window [Nm]."""
    data, angles = mujoco.MjData(engine), np.empty_like(torque)
    data.qpos, data.qvel = windows.q[row], windows.qd[row]
    for k, applied in enumerate(torque):
        data.qfrc_applied = applied
        for _ in range(PARTS):
            mujoco.mj_step(engine, data)
        angles[k] = data.qpos
    return np.asarray(angles[ENDS - 1])


if __name__ == "__main__":
    main()

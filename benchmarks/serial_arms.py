"""Contact forces of arms of other makers on the virtual test stand, seed by seed.

    python -m benchmarks.serial_arms <urdf> [<tip>] [--seeds <n>] [--quick]

The arm is described from its URDF, once with torque sensors in its joints and once with motor
currents alone. Each seed draws postures, motions, forces, where they act, and all noise: six
recordings of 10 s to fit, one of 20 s without contact that no fit has seen, and one that is touched
five times. Two recordings are of one day; friction differs from day to day and from run to run as
the identification assumes, and places of contacts as the force estimate does. Printed are, of F̂ᵐᵃᵖ
in contact, the error beside that of an estimate of zero and the share inside the 95 % band; the
contacts found, and alarms a minute without contact. `example-robot-data` on PyPI has a Panda.
"""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from benchmarks.harness.options import options_of
from benchmarks.harness.stand import CURRENTS, SETTINGS, Taken, currents, fitted_map, simulated
from ur5lib.force.contact_prior import ContactPrior, typical_force
from ur5lib.force.matching import match
from ur5lib.force.problem import fmap_problem
from ur5lib.force.thresholds import alarm_threshold, alarms
from ur5lib.force.wrench_estimate import WrenchEstimate
from ur5lib.identification.currents import (
    DAY_TO_DAY_STD,
    RUN_TO_RUN_STD,
)
from ur5lib.recordings.entries import RtdeFiles
from ur5lib.robots.description import Motor, Robot
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.stand.layout import ROBOT_FILES
from ur5lib.steps.fit_residuals import residual_models
from ur5lib.timeseries.segments import spans

FIRST, SEEDS, SECONDS, QUICK = 2, 20, 20.0, 10.0  # on seeds 0 and 1, `BLUR` was chosen
MOTION = {"kind": "fourier", "period_s": 20, "harmonics": 10, "amplitude_rad": 0.5}
# shares of the limits of speed: of six fit recordings, a free one, a touched one
SHARES = (0.5, 0.3, 0.1, 0.5, 0.3, 0.1, 0.3, 0.3)
FITTED, OF_A_DAY = len(SHARES) - 2, 2
BEND, SWAY = 0.5, 0.3  # rad; of each joint from its middle; variation between postures
FORCES = 10.0, 60.0  # N, range of pushes
CONSTANT, GEAR, ROTOR = 0.1, 100.0, 2e-5  # Nm/A, 1, kg m²: of the motors of the arm with currents
LEVER = 0.03  # m, standard deviation of the place of a contact


def main() -> None:
    """Print the figures of all seeds."""
    options = options_of(__doc__)
    options.add_argument("urdf", type=Path, help="the arm")
    options.add_argument("tip", nargs="?", help="its flange; by default what the last joint turns")
    options.add_argument("--seeds", type=int, default=SEEDS, help="how many")
    given = options.parse_args()
    torch.set_num_threads(1)
    seeds, length = (1, QUICK) if given.quick else (given.seeds, SECONDS)
    chosen = range(FIRST, FIRST + seeds)
    robot, _ = robot_from_urdf(given.urdf, tip=given.tip)
    for name, arm in (("torque sensors", robot), ("currents", with_motors(robot))):
        rows = pd.DataFrame([row for seed in chosen for row in figures(arm, seed, length)])
        print(f"{robot.name} with {name}, {seeds} seeds")
        print(rows.groupby("quantity", sort=False)[["value"]].agg(["mean", "min", "max"]).round(3))


def with_motors(robot: Robot) -> Robot:
    """Return an arm with motor currents and gears in place of torque sensors."""
    known = {"torque_constant": CONSTANT, "gear_ratio": GEAR, "rotor_inertia": ROTOR}
    motors = {n: Motor.model_validate(own.model_dump() | known) for n, own in robot.motors.items()}
    return robot.model_copy(update={"motors": motors, "effort": "current"}).with_rotors()


def plans(robot: Robot, seed: int, seconds: float) -> Iterator[dict[str, Any]]:
    """Yield the plans of the fit recordings, of a free one, and of a touched one."""
    random = np.random.default_rng(seed)
    middle = np.clip(robot.position_limits(), -np.pi, np.pi).mean(axis=1)
    bent = middle + BEND * (-1.0) ** np.array(robot.joint_numbers)
    rubbing = np.random.default_rng([seed, 1])  # so that motions do not depend on it
    days = 1 + DAY_TO_DAY_STD * rubbing.normal(size=(len(SHARES) // OF_A_DAY, len(bent)))
    runs = 1 + RUN_TO_RUN_STD * rubbing.normal(size=(len(SHARES), len(bent)))
    for k, share in enumerate(SHARES):
        posture = bent + random.uniform(-SWAY, SWAY, len(bent))
        friction = [*(days[k // OF_A_DAY] * runs[k])]
        motion = MOTION | {"draw": 10 * seed + k, "posture": posture, "limit_share": share}
        length = seconds if k >= FITTED else seconds / 2
        own = {"trajectory": motion, "seed": 10 * seed + k, "seconds": length}
        own |= {"coulomb_factor": friction, "viscous_factor": friction}
        yield own | ({"contacts": touches(random, seconds)} if k == len(SHARES) - 1 else {})


def touches(random: np.random.Generator, seconds: float) -> list[dict[str, Any]]:
    """Return two pushes, a hand, a spring and a grasped load, one after the other.

    Each acts at another place near the tip.
    """
    kinds: list[dict[str, Any]] = [
        {"kind": "push", "force": vector(random, *FORCES)},
        {"kind": "hand", "displacement": vector(random, 0.03, 0.1)},
        {"kind": "push", "force": vector(random, *FORCES)},
        {"kind": "spring", "displacement": vector(random, 0.03, 0.1)},
        {"kind": "load", "mass": random.uniform(1.0, 3.0)},
    ]
    each = (seconds - 1.0) / len(kinds)
    return [
        own
        | {"start_s": 1 + k * each, "seconds": each / 2}
        | {"point": (LEVER * random.normal(size=3)).tolist()}
        for k, own in enumerate(kinds)
    ]


def vector(random: np.random.Generator, least: float, most: float) -> list[float]:
    """Return a vector of random direction, with a random norm from `least` to `most`."""
    way = random.normal(size=3)
    return list(random.uniform(least, most) * way / np.linalg.norm(way))


def taken(robot: Robot, plan: dict[str, Any], folder: Path) -> Taken:
    """Return a recording, simulated in a folder and read like a real one."""
    file = ROBOT_FILES["rtde-csv"]
    entry = RtdeFiles(format="rtde-csv", folder=str(folder), file=file)
    return simulated(robot, plan, entry)


def figures(robot: Robot, seed: int, seconds: float) -> Iterator[dict[str, Any]]:
    """Yield the figures of one seed."""
    with tempfile.TemporaryDirectory() as folder:
        drawn = enumerate(plans(robot, seed, seconds))
        *fitted, free, touched = [taken(robot, plan, Path(folder, str(k))) for k, plan in drawn]
        friction = fitted_map(fitted)
        known = {id(own): currents(friction, own) for own in (*fitted, free, touched)}
        recordings = [(known[id(own)], own.motion) for own in fitted]
        residuals = residual_models(recordings, friction, CURRENTS.cutoff)
        prior = ContactPrior(typical_force(robot), LEVER)

        def estimated(own: Taken) -> WrenchEstimate:
            found = fmap_problem(own.motion, known[id(own)], residuals)
            assert found is not None
            return found.solve(own.kinematics.jacobian[found.rows], prior)

        rate = SETTINGS.alarms.false_per_min
        odds = [estimated(own).log_odds for own in fitted]
        threshold = alarm_threshold(odds, [own.motion.period for own in fitted], rate)
        false = len(alarms(estimated(free).log_odds, threshold))
        yield {"quantity": "false alarms a minute", "value": 60 * false / seconds}
        yield from in_contact(touched, estimated(touched), threshold)


def in_contact(own: Taken, found: WrenchEstimate, threshold: float) -> Iterator[dict[str, Any]]:
    """Yield error, band and detection of a touched recording."""
    true = np.nan_to_num(own.truth.at(own.motion.time).wrench)
    rows = (true != 0).any(axis=1)
    force, error = true[rows, :3], (found.wrench - true)[rows]
    inside = np.abs(error) <= 1.96 * found.std[rows]
    yield {"quantity": "force in contact, error [N]", "value": np.abs(error[:, :3]).mean()}
    yield {"quantity": "of an estimate of zero [N]", "value": np.abs(force).mean()}
    yield {"quantity": "its 95 % band, half [N]", "value": 1.96 * found.std[rows, :3].mean()}
    yield {"quantity": "force inside its band", "value": inside[:, :3].mean()}
    yield {"quantity": "moment inside its band", "value": inside[:, 3:].mean()}
    contacts = spans(rows.astype(float), 0.5, 0.5)
    hit = {contact for _, contact in match(alarms(found.log_odds, threshold), contacts)}
    yield {"quantity": "contacts found", "value": len(hit) / len(contacts)}


if __name__ == "__main__":
    main()

"""What comes back from the virtual test stand, seed by seed, and how often its intervals hold.

Three recordings to fit are simulated for each seed, with another motion and all noise drawn anew,
and read as real ones are. Counted are, for each quantity, the values whose stated 95 % interval
holds the truth; and the largest error of a clock.
"""

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from ur5lib.device_clock import device_clock
from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.identification.rotor_inertia import fit_rotor_inertia
from ur5lib.intake import take_in
from ur5lib.report.truth_table import Row, clock_rows, imu_rows, rotor_rows
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.signals.imu_calibration import ImuRecord, calibrate
from ur5lib.signals.imu_record import imu_record
from ur5lib.signals.resampling import resample
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.tables import Array, channel, named, read_json

SEEDS, RECORDINGS, SECONDS = 20, 3, 20.0
ORDER, CUTOFF = 4, 2.0  # of what an IMU is compared at, as in the settings' defaults


def main(seeds: int = SEEDS) -> None:
    """Print how many intervals hold the truth."""
    torch.set_num_threads(1)
    rows = pd.DataFrame([row for seed in range(seeds) for row in recovered(seed)])
    print(f"{seeds} seeds, {RECORDINGS} recordings of {SECONDS:g} s each")
    for quantity, part in rows.groupby("quantity", sort=False):
        inside, off = part["within95"] == "yes", (part["estimate"] - part["truth"]).abs()
        print(
            f"{quantity:>20}: {inside.sum():>4} of {len(part):>4} intervals hold the truth "
            f"({inside.mean():.0%}), largest error {off.max():.2g} {part['unit'].iloc[0]}"
        )


def recovered(seed: int, count: int = RECORDINGS, seconds: float = SECONDS) -> Iterator[Row]:
    """Rows of clocks, rotor inertias and the IMU beside the truth, from recordings of one seed."""
    robot = load_robot(robot_path("ur5"))
    imus, torques = [], []
    for k in range(count):
        with tempfile.TemporaryDirectory() as folder:
            clocks, imu, torque, truth = recording(robot, 100 * seed + k, seconds, Path(folder))
        yield from clock_rows(clocks, truth)
        imus.append(imu)
        torques.append(torque)
    fit = fit_rotor_inertia(*zip(*torques, strict=True))
    found = {"from": torques, "value": fit.value._asdict(), "std_error": fit.std_error._asdict()}
    yield from rotor_rows(found, robot.models[truth["model"]].rotor_inertias)
    yield from imu_rows(asdict(calibrate(imus)), truth["plan"]["imu"])


def recording(
    robot: Robot, draw: int, seconds: float, folder: Path
) -> tuple[dict[str, Any], ImuRecord, tuple[Array, Array, Array], Any]:
    """Clocks, what the IMU and the targets tell, and the truth of one simulated recording."""
    plan = {"trajectory": {"kind": "fourier", "draw": draw}, "seed": draw, "imu": {}}
    wanted = SimulatedRecording.model_validate(plan | {"seconds": seconds})
    simulate(robot, wanted, "thesis-csv", folder, folder / "truth")
    intake = take_in({"format": "thesis-csv", "folder": str(folder)}, robot, 0.1)
    signals, imu = intake.robot, intake.sensors["imu"]
    rotation, _, jacobian = flange_kinematics(robot, channel(signals, "actual_q"))
    clock, _ = device_clock(imu, intake.quality["starts"]["imu"], signals, rotation, jacobian)
    read = resample(imu, clock, signals["time"].to_numpy())
    kinematics = pd.DataFrame(named(rotation, "R6") | named(jacobian, "J"))
    point = np.array(robot.mounting.imu)
    record = imu_record(
        pd.concat([signals, read], axis="columns"), kinematics, point, ORDER, CUTOFF
    )
    return {"imu": asdict(clock)}, record, torques(robot, signals), read_json(folder / "truth.json")


def torques(robot: Robot, signals: pd.DataFrame) -> tuple[Array, Array, Array]:
    """What rigid links leave of the controller's torque, q̇ and q̈, at the targets."""
    states = [channel(signals, f"target_{name}") for name in ("q", "qd", "qdd")]
    rigid = inverse_dynamics(build_arm(robot, robot.chosen_model), *map(torch.from_numpy, states))
    return channel(signals, "target_moment") - rigid.numpy(), states[1], states[2]


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))

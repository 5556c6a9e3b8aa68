"""The files of a designed trajectory: for `ur5 record`, for a UR's controller, for the test
stand."""

from collections.abc import Mapping
from pathlib import Path as File

import numpy as np
import yaml

from ur5lab.excitation.design import Design
from ur5lab.excitation.trajectory import Path, WorkCell
from ur5lib.robots.description import Payload
from ur5lib.tables import json_text, write_text
from ur5lib.timeseries.arrays import Array

SERVO_RATE = 125.0  # Hz; every UR supports servoj at this rate
REST_DURATION = 3.0  # s; in total before and after the motion on the test stand
STATES_PER_MOVE = 20  # checked between two way-points
WAY_POINT_SPACINGS = (1.0, 0.5, 0.25, 0.1, 0.04)  # s; the widest without collision is used
APPROACH_ARGUMENTS = "a=0.5, v=0.5"  # rad/s², rad/s; of the movej to the start
SERVO_ARGUMENTS = "t=0.008, lookahead_time=0.1, gain=300"
STUDY_NAME = "excitation"


def write_files(
    folder: File, request: Mapping[str, object], payload: Payload | None, design: Design
) -> None:
    """Write all files of a trajectory that `ur5 excite` designed; see docs/excitation.md.

    request: robot, question and seed. Raises InputError where they cannot be written.
    """
    time, states = design.path.sampled(SERVO_RATE)
    texts = {
        "trajectory.csv": _csv(np.column_stack([time, states.q])),
        "way_points.csv": _csv(way_points(design.task.cell, design.path)),
        "stand.yaml": stand_study(str(request["robot"]), payload, design.path),
        "excitation.json": json_text({**request, **summary(design)}),
    }
    if design.task.cell.robot.is_ur():
        texts["trajectory.script"] = script(states.q)
    for name, text in texts.items():  # all of them are made before the first is written
        write_text(text, folder / name)


def summary(design: Design) -> dict[str, object]:
    """Return a trajectory, its margins and its `Worth` as plain data."""
    problem, worth = design.task.problem, design.worth
    columns = {
        "parameter": problem.names(),
        "unit": problem.units(),
        "std_error_prior": worth.prior,
        "std_error_before": worth.before,
        "std_error_after": worth.after,
    }
    return {
        "path": design.path,
        "margins": design.margins,
        "noise": problem.noise,
        "log_det": worth.log_det,
        "log_det_gain": worth.gain,
        "condition_number_of_regressor": worth.regressor_condition,
        "condition_number": worth.condition,
        "parameters": [
            dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
        ],
    }


def way_points(cell: WorkCell, path: Path) -> Array:
    """Return way-points (M, n) [rad] along a path, so dense that straight moves do not collide."""
    for spacing in WAY_POINT_SPACINGS:
        points = path.sampled(1 / spacing)[1].q
        steps = np.linspace(points[:-1], points[1:], STATES_PER_MOVE, axis=1).reshape(
            -1, points.shape[1]
        )
        if not (cell.capsules.near(steps).distance < cell.limits.clearance / 2).any():
            break
    return points


def script(q: Array) -> str:
    """Return a URScript program that moves to the start and streams q (N, 6) [rad] at 125 Hz.

    A controller starts a program when it receives the last line, `end`; a call after that line
    would be another program and replace this one. Source: Universal Robots' script manual,
    Connecting to URControl.
    """
    lines = [f"  servoj({_list(row)}, {SERVO_ARGUMENTS})" for row in q]
    start = f"  movej({_list(q[0])}, {APPROACH_ARGUMENTS})"
    return "\n".join(["def excite():", start, *lines, "  stopj(2.0)", "end", ""])


def stand_study(robot: str, payload: Payload | None, path: Path) -> str:
    """Return a study that simulates the recording on the virtual test stand."""
    trajectory = {
        "kind": "series",
        "posture": path.posture.tolist(),
        "period_s": path.seconds,
        "coefficients": path.coefficients.tolist(),
    }
    plan = {"trajectory": trajectory, "seconds": path.seconds + REST_DURATION}
    if payload is not None:
        plan["payload"] = payload.model_dump(mode="json")
    recording = {
        "name": "designed",
        "robot": robot,
        "format": "rtde-csv",
        "role": "fit",
        "simulate": plan,
    }
    study = {"study": STUDY_NAME, "title": "A designed trajectory", "recordings": [recording]}
    return yaml.safe_dump(study, sort_keys=False, default_flow_style=None)


def _csv(rows: Array) -> str:
    """Return rows of numbers without a header, as `ur5 record --move` reads them."""
    return "".join(",".join(f"{value:.6f}" for value in row) + "\n" for row in rows)


def _list(angles: Array) -> str:
    return f"[{', '.join(f'{angle:.6f}' for angle in angles)}]"

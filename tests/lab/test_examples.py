"""The motions in documents can be read, and moved along."""

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import PROJECT
from tests.examples import Example, examples
from ur5lab.recorder.commanded_motion import read_motion, refusals
from ur5lab.recorder.move_program import planned_motion, read_program
from ur5lib.robots.description import load_robot, robot_path

EXAMPLES = [own for page in sorted((PROJECT / "docs").glob("*.md")) for own in examples(page)]


def of_kind(kind: str) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("example", [e for e in EXAMPLES if e.kind == kind], ids=str)


@of_kind("way-points")
def test_way_points_can_be_read(example: Example, tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text(example.text)
    assert np.ptp(read_motion(path, 1.0).q, axis=0).min() > 0.1


@of_kind("moves")
def test_moves_are_possible(example: Example, tmp_path: Path) -> None:
    path, robot = tmp_path / "moves.txt", load_robot(robot_path("ur5e"))
    path.write_text(example.text)
    motion = planned_motion(read_program(path), robot, np.zeros(6), 1.0, 0.0)
    assert [*refusals(motion, robot, motion.q[0], 0.0)] == []

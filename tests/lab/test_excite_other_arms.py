"""`ur5 excite` for arms of any number of joints, with torque sensors or with currents."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.serial_arms import with_motors
from tests.lab.test_excitation_design import check_gradient
from tests.robots.test_from_urdf import made_up, planar, saved
from ur5lab import excite
from ur5lab.collisions import Capsules, Surroundings
from ur5lab.excitation import design as search
from ur5lab.excitation.design import Effort, design, free_postures, random_path
from ur5lab.excitation.objective import Task
from ur5lab.excite import ExciteOptions, task_of
from ur5lib.cli import app
from ur5lib.commands.described import describe_urdf
from ur5lib.dynamics.flange import independent_twists
from ur5lib.errors import InputError
from ur5lib.excitation.outlook import feels_forces
from ur5lib.excitation.problem import nominal_maps
from ur5lib.robots.description import Motor, Robot, load_robot, robot_path
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.study.reading import read_study

SECONDS, TABLE = 5.0, -5.0  # s, m
QUICK = Effort(1, 0, ((1e3, 10),))


def arm(count: int, folder: Path, currents: bool = False) -> Robot:
    robot, _ = robot_from_urdf(saved(planar(2) if count == 2 else made_up(count), folder))
    return with_motors(robot) if currents else robot


def task(robot: Robot, question: str = "model") -> Task:
    return task_of(ExciteOptions("", SECONDS, question, None, TABLE, None, 0), robot, None)


@pytest.mark.parametrize(
    ("count", "currents", "question"),
    [(2, False, "model"), (3, True, "payload"), (4, False, "force-bands"), (8, True, "model")],
)
def test_the_gradient_is_that_of_finite_differences(
    count: int, currents: bool, question: str, tmp_path: Path
) -> None:
    check_gradient(task(arm(count, tmp_path, currents), question), 1.3)


@pytest.mark.parametrize("count", [2, 7])
def test_all_limits_are_kept_at_1_khz_and_used(count: int, tmp_path: Path) -> None:
    own = task(arm(count, tmp_path))
    designed = design(own, 0, QUICK)
    assert designed.margins.broken() == []
    assert own.cell.margins(designed.path.sampled(1000)[1]).broken() == []
    assert max(share.max() for share in designed.margins.used.values()) > 0.9
    random = np.random.default_rng(0)
    rivals = [random_path(own, random, free_postures(own.cell, random)) for _ in range(3)]
    values = [own.criterion(own.information(path))[0] for path in (designed.path, *rivals)]
    assert values[0] > max(values[1:])


def test_the_files_are_for_the_arm_and_its_range(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A joint that turns to one side only; no script for a UR's controller; the stand follows."""
    monkeypatch.chdir(tmp_path)
    root = made_up(4)
    limit = next(root.iter("limit"))
    limit.set("lower", "-3")
    limit.set("upper", "-0.1")
    describe_urdf(saved(root, tmp_path), None, "tool", "mine")
    monkeypatch.setattr(
        excite, "design", lambda task, seed, _, told: search.design(task, seed, QUICK, told)
    )
    words = ["excite", "--robot", "mine", "--seconds", "5", "--table", "-5", "--output", "out"]
    done = CliRunner().invoke(app, words, catch_exceptions=False)
    assert "the arm's own driver" in done.output
    assert "ur5 record" not in done.output
    written = {path.name for path in Path("out").iterdir()}
    assert {"trajectory.csv", "way_points.csv", "stand.yaml", "excitation.json"} <= written
    assert "trajectory.script" not in written
    time, *q = np.loadtxt("out/trajectory.csv", delimiter=",").T
    assert (time[-1], len(q)) == (SECONDS, 4)
    assert -3 < q[0].min() < q[0].max() < -0.1
    (recording,) = read_study(Path("out/stand.yaml")).recordings
    assert isinstance(recording.simulate, SimulatedRecording)
    simulate(load_robot("robots/mine.yaml"), recording.simulate, "rtde-csv", tmp_path, tmp_path)


def test_a_planar_arm_has_no_more_twists_than_its_plane_allows(tmp_path: Path) -> None:
    robots = [robot_from_urdf(saved(root, tmp_path))[0] for root in (planar(7), made_up(3))]
    assert [*map(independent_twists, [*robots, arm(8, tmp_path)])] == [3, 3, 6]
    assert [feels_forces(robots[0]), feels_forces(arm(8, tmp_path))] == [False, True]
    cell = task(robots[0]).cell
    assert (cell.singular_value(free_postures(cell, np.random.default_rng(0))) > 0.03).all()


def test_the_table_is_level_and_what_stands_on_it_does_not_touch_it(tmp_path: Path) -> None:
    """Of an arm whose first axis lies; its base frame does, too."""
    robot, _ = robot_from_urdf(saved(planar(3), tmp_path))
    down = Capsules(robot, Surroundings(table=0.0), 0.02).near(np.array([[np.pi, 0.0, 0.0]]))
    up = Capsules(robot, Surroundings(table=0.0), 0.02).near(np.zeros((1, 3)))
    assert {pair for pair in down.pairs if "table" in pair} == {
        ("link_2", "table"),
        ("link_3", "table"),
    }
    assert up.pairs == []


def test_sensors_are_known_better_than_currents(tmp_path: Path) -> None:
    own, motors = (task(arm(7, tmp_path, currents)).problem for currents in (False, True))
    gains, constants = (one.standard_errors(one.prior)[one.of_currents] for one in (own, motors))
    assert (gains[::5] < 0.05).all()
    assert (constants[::5] > 0.2 / motors.theta[motors.of_currents][::5]).all()
    assert own.names()[own.of_currents][:2] == ["gain of joint 1", "bias of joint 1"]
    assert np.isinf(own.noise.torque).all()


def test_an_arm_without_torque_constants_is_told(tmp_path: Path) -> None:
    robot = load_robot(robot_path("ur5e"))
    bare = Motor(position_max=6, velocity_max=3, torque_max=100)
    motors = dict.fromkeys(robot.motors, bare)
    with pytest.raises(InputError, match="`torque_constant` and `gear_ratio`"):
        nominal_maps(robot.model_copy(update={"motors": motors}))

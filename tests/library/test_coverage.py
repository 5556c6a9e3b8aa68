"""How much of a recording each device covers."""

import pytest

from tests.conftest import said
from ur5lib.recordings.starts import robot_coverage, sensor_coverage

LENGTH, STD = 200.0, 0.5  # s, of the robot's recording, and of a sensor's start stamp
SENSOR = 2 + 0.005 * LENGTH + 3 * STD  # s that may be missing: tolerance, drift, start stamp
ROBOT = 2 + 0.005 * LENGTH


@pytest.mark.parametrize("late", [0.0, 1.0])
@pytest.mark.parametrize(("beyond", "count"), [(-0.01, 0), (0.01, 1)])
def test_a_sensor_may_lack_as_much_as_its_clock_may_err(
    late: float, beyond: float, count: int
) -> None:
    span = late, LENGTH - (SENSOR - late) - beyond
    assert len(sensor_coverage("force", span, (0.0, LENGTH), STD)) == count


@pytest.mark.parametrize(("beyond", "count"), [(-0.01, 0), (0.01, 1)])
def test_a_robot_may_lack_as_much_as_its_clock_may_drift(beyond: float, count: int) -> None:
    robot = 0.0, LENGTH - ROBOT - beyond
    assert len(robot_coverage(robot, (0.0, LENGTH))) == count


@pytest.mark.parametrize(("late", "starts"), [(0.04, False), (0.06, True)])
def test_a_delay_that_rounds_to_nothing_is_not_mentioned(late: float, starts: bool) -> None:
    (finding,) = sensor_coverage("imu", (late, 100.0), (0.0, LENGTH), STD)
    assert ("after the robot" in said(finding)) == starts
    assert f"ends 100.0 s before {'it' if starts else 'the robot'};" in said(finding)

"""The sketch for ROS 2 in docs/live.md, compiled against stand-ins of its messages."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import PROJECT
from tests.topics.live.made_arm import exported, push, samples
from tests.topics.live.test_live import HEADER, stream_of, written
from ur5lib.commands.exported import ROS_NAMES
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.live.live import CONTACT, FREE, SUSPECTED, UNKNOWN, Live

MESSAGES = {  # as rosidl makes them of the fields that the sketch uses
    "sensor_msgs/msg/joint_state.hpp": """
        namespace builtin_interfaces::msg {
            struct Time { std::int32_t sec{}; std::uint32_t nanosec{}; }; }
        namespace std_msgs::msg {
            struct Header { builtin_interfaces::msg::Time stamp; std::string frame_id; }; }
        namespace sensor_msgs::msg { struct JointState {
            std_msgs::msg::Header header; std::vector<std::string> name;
            std::vector<double> position, velocity, effort; }; }""",
    "geometry_msgs/msg/wrench_stamped.hpp": """
        #include <sensor_msgs/msg/joint_state.hpp>
        namespace geometry_msgs::msg {
            struct Vector3 { double x{}, y{}, z{}; };
            struct Wrench { Vector3 force, torque; };
            struct WrenchStamped { std_msgs::msg::Header header; Wrench wrench; }; }""",
    "my_robot_msgs/msg/contact_force.hpp": """
        #include <geometry_msgs/msg/wrench_stamped.hpp>
        namespace my_robot_msgs::msg { struct ContactForce {
            geometry_msgs::msg::WrenchStamped wrench; std::array<double, 36> covariance{};
            std::uint8_t contact{}; }; }""",
}
NO_RATE = -9e9  # in place of a velocity that is not stated
# reads lines of seconds, nanoseconds, n, names, positions, velocities, efforts
NODE = """
#include <cstdio>
#include <iostream>
int main(int, char** arguments) {
  ForceOfArm force(arguments[1], {arguments + 2, arguments + 8});
  sensor_msgs::msg::JointState state;
  for (std::size_t n; std::cin >> state.header.stamp.sec >> state.header.stamp.nanosec >> n;) {
    state.name.resize(n);
    for (auto& name : state.name) std::cin >> name;
    for (auto* values : {&state.position, &state.velocity, &state.effort}) {
      values->resize(n);
      for (double& value : *values) std::cin >> value;
    }
    if (state.velocity[0] == -9e9) state.velocity.clear();
    const auto out = force.step(state);
    if (out.wrench.header.stamp.nanosec != state.header.stamp.nanosec) return 1;
    const auto& [f, n_] = out.wrench.wrench;
    for (double value : {f.x, f.y, f.z, n_.x, n_.y, n_.z}) std::printf("%.17g ", value);
    for (double value : out.covariance) std::printf("%.17g ", value);
    std::printf("%d\\n", out.contact);
  }
}
"""


@pytest.fixture(scope="module")
def node(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page's class, compiled."""
    if (compiler := shutil.which("g++")) is None:
        pytest.skip("no g++ is installed, so the sketch is not compiled")
    folder = tmp_path_factory.mktemp("ros")
    for name, text in MESSAGES.items():
        (folder / name).parent.mkdir(parents=True)
        includes = "".join(
            f"#include <{own}>\n" for own in ("array", "cstdint", "string", "vector")
        )
        (folder / name).write_text(f"#pragma once\n{includes}{text}")
    [sketch] = re.findall(
        r"```cpp\n(.*?)```", (PROJECT / "docs" / "live.md").read_text(), re.DOTALL
    )
    (folder / "node.cpp").write_text(sketch + NODE)
    flags = ["-std=c++17", "-Wall", "-Wextra", "-Werror", f"-I{HEADER}", f"-I{folder}"]
    subprocess.run([compiler, *flags, folder / "node.cpp", "-o", folder / "node"], check=True)
    return folder / "node"


def line(time: float, names: list[str], parts: list[Array]) -> str:
    """A sample as NODE reads it, its joints in the order of their names, as ROS states them."""
    order = np.argsort(names)
    seconds, nanoseconds = divmod(round(1e9 * time), 10**9)
    values = written(np.array(parts)[:, order].ravel())
    return " ".join([f"{seconds} {nanoseconds} {len(names)}", *np.array(names)[order], *values])


@pytest.mark.parametrize("velocities", [True, False])
def test_the_sketch_for_ros_answers_as_the_reference(
    velocities: bool, node: Path, tmp_path: Path
) -> None:
    """A gripper's joint stands between those of the arm, and one message lacks one of these."""
    arm, run = exported(), samples(8.0, True, push(5.0, 6.0, 20.0, 0.0, 5.0))
    run = run if velocities else run._replace(qd=None)
    (tmp_path / "arm.json").write_text(json.dumps(arm))
    reference, lines, expected = Live(arm), [], []
    for row, (time, q, qd, current) in enumerate(stream_of(run)):
        lacks = row == 100
        names = [*ROS_NAMES, "finger_joint"]
        names[2] = "another_joint" if lacks else names[2]
        parts = [q, np.full(6, NO_RATE) if qd is None else qd, current]
        lines.append(line(time, names, [np.append(part, part[0]) for part in parts]))
        now = reference.step(time, q * np.nan if lacks else q, qd, current)
        code = (FREE, SUSPECTED, CONTACT, UNKNOWN).index(now.contact)
        expected.append([*now.wrench, *np.diag(now.std**2).ravel(), code])
    command = [node, tmp_path / "arm.json", *ROS_NAMES]
    stream = "\n".join(lines)
    done = subprocess.run(command, input=stream, capture_output=True, text=True, check=True)
    found = np.loadtxt(done.stdout.splitlines())
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7)  # nanoseconds of a stamp
    assert {*found[:, -1]} == {0, 1, 2, 3}

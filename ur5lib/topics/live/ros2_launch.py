"""Start the node of the contact force: `ros2 launch ./ur5_force.launch.py frame:=base`."""

from pathlib import Path
from typing import Any

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

HERE = Path(__file__).resolve().parent


def generate_launch_description() -> Any:
    """Return the node, with its parameters as arguments."""
    defaults = {"arm": str(HERE / "arm.json"), "input": "auto", "frame": "base"}
    node = Node(
        executable=str(HERE / "ur5_force.py"),
        name="ur5_force",
        parameters=[{name: LaunchConfiguration(name) for name in defaults}],
        output="screen",
    )
    arguments = [DeclareLaunchArgument(name, default_value=own) for name, own in defaults.items()]
    return LaunchDescription([*arguments, node])

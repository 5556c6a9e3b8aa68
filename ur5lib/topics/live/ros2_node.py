#!/usr/bin/env python3
"""A ROS 2 node that states the contact force on a running arm, from its joint_states.

It needs rclpy, NumPy, and next to it `live.py` and `arm.json`, which `ur5 export --format ros2`
writes. docs/live.md describes its topics and parameters.
"""

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import AccelWithCovarianceStamped, WrenchStamped
from live import LIKELY, UNKNOWN, Answer, Live, read_arm
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

HERE = Path(__file__).resolve().parent
DRIVER = QoSProfile(depth=1000)  # reliable and volatile, as joint_state_broadcaster publishes
ANY = QoSOverridingOptions.with_default_policies()
SILENCE = 1.0  # s without samples, after which nothing is known


class ContactForce(Node):
    """The node; raises OSError and ValueError where its arm cannot be read."""

    def __init__(self) -> None:
        super().__init__("ur5_force")
        path = Path(self.declare_parameter("arm", str(HERE / "arm.json")).value)
        arm = read_arm(path.read_text(encoding="utf-8"))
        self.arm = Live(arm, self.declare_parameter("input", "auto").value)
        self.name = str(arm["arm"])
        self.joints = list(self.declare_parameter("joints", list(arm["joints"])).value)
        if len(self.joints) != len(arm["links"]):
            raise ValueError(f"joints: {len(arm['links'])} names are needed, from base to flange")
        self.frame = self.declare_parameter("frame", "base").value
        self.heard, self.beside = time.monotonic(), ""
        self.wrench = self.create_publisher(
            WrenchStamped, "~/wrench", DRIVER, qos_overriding_options=ANY
        )
        self.spread = self.create_publisher(
            AccelWithCovarianceStamped, "~/wrench_with_covariance", DRIVER
        )
        self.contact = self.create_publisher(DiagnosticArray, "~/contact", DRIVER)
        self.create_subscription(
            JointState, "joint_states", self.take, DRIVER, qos_overriding_options=ANY
        )
        self.create_service(Trigger, "~/tare", self.tare)
        self.create_timer(SILENCE, self.watch)

    def take(self, state: Any) -> None:
        """Answer a sample, at its stamp; messages of other joints alone are none."""
        places = [state.name.index(own) if own in state.name else -1 for own in self.joints]
        if max(places) < 0:
            return
        self.heard, stamp = time.monotonic(), state.header.stamp
        q, qd, effort = (
            of_joints(own, places) for own in (state.position, state.velocity, state.effort)
        )
        rates = None if np.isnan(qd).all() else qd
        answer = self.arm.step(stamp.sec + 1e-9 * stamp.nanosec, q, rates, effort)
        self.publish(stamp, answer.wrench.tolist(), answer.std)
        lacks = [own for own, place in zip(self.joints, places, strict=True) if place < 0]
        reason = f"joint_states lacks {', '.join(lacks)}" if lacks else self.arm.reason
        if np.isnan(effort).all():
            reason = "joint_states states no effort"
        stated = answer.contact == UNKNOWN or answer.off_flange >= LIKELY
        self.tell(stamp, answer, reason if stated else "")

    def publish(self, stamp: Any, wrench: list[float], std: Any) -> None:
        """Publish a wrench, alone and with its covariance, of which the diagonal is known."""
        alone, both = WrenchStamped(), AccelWithCovarianceStamped()
        for message, parts in (
            (alone, (alone.wrench.force, alone.wrench.torque)),
            (both, (both.accel.accel.linear, both.accel.accel.angular)),
        ):
            message.header.stamp, message.header.frame_id = stamp, self.frame
            for part, values in zip(parts, (wrench[:3], wrench[3:]), strict=True):
                part.x, part.y, part.z = values
        both.accel.covariance = np.diag(std**2).ravel()
        self.wrench.publish(alone)
        self.spread.publish(both)

    def tell(self, stamp: Any, answer: Answer, reason: str) -> None:
        """Publish the state of contact, and the reason where it or the wrench is unknown."""
        odds = self.arm.evidence
        status = DiagnosticStatus(name=self.get_fully_qualified_name(), hardware_id=self.name)
        faulty = answer.contact == UNKNOWN or self.beside
        status.level = DiagnosticStatus.WARN if faulty else DiagnosticStatus.OK
        status.message = answer.contact
        values = {
            "probability": repr(float(1 / (1 + np.exp(-np.clip(odds, -700, 700))))),
            "log_odds": repr(odds),
            "link": repr(answer.link),
            "off_flange": repr(answer.off_flange),
            "reason": reason,
            "beside": self.beside,
        }
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        message = DiagnosticArray(status=[status])
        message.header.stamp, message.header.frame_id = stamp, self.frame
        self.contact.publish(message)

    def tare(self, _: Any, response: Any) -> Any:
        """Begin anew: what the arm feels in the next second at rest is no contact."""
        self.arm.restart()
        response.success = time.monotonic() - self.heard < SILENCE
        response.message = (
            "the arm's next second at rest is its background; until then, contact is unknown"
            if response.success
            else "no joint_states come; start the driver, then call again"
        )
        return response

    def watch(self) -> None:
        """Look for other nodes of this name, and for silence."""
        topic, count = self.wrench.topic_name, self.count_publishers(self.wrench.topic_name)
        several = f"{count} nodes publish {topic}; end the others, or rename this one by __node:="
        self.beside = several if count > 1 else ""
        silent = time.monotonic() - self.heard
        if silent > SILENCE:
            now = self.get_clock().now().to_msg()
            self.tell(
                now, self.arm.nothing(), f"no joint_states of {self.name} came for {silent:.0f} s"
            )


def of_joints(values: Sequence[float], places: Sequence[int]) -> Any:
    """Return the values of the arm's joints, NaN where a message lacks them."""
    return np.array([values[own] if 0 <= own < len(values) else np.nan for own in places])


def main() -> None:
    """Run the node until Ctrl-C, or until ROS is shut down."""
    rclpy.init()
    try:
        rclpy.spin(ContactForce())
    except (OSError, ValueError, ParameterException) as error:
        sys.exit(f"ur5_force: {error}")
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()

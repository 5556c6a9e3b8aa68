"""A publisher and a listener in ROS 2, each a process of its own, with ROS's Python.

`python ros_processes.py publish PLAN RATE KEPT NODES DONE` sends the messages of PLAN (JSON) when
so many nodes answer, with a history of KEPT messages, and writes when it did; `... listen FILE
NODES` writes the serialized messages of all topics of so many nodes, with the times of their
arrival. A probe before the samples shows that all have found each other, one after them that no
answer is on its way. Times [ns] are of the system's clock, of arrivals as the middleware states
them, since Python may be late.
"""

import json
import pickle
import sys
import time
from collections import Counter
from functools import partial
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import AccelWithCovarianceStamped, WrenchStamped
from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

QOS = QoSProfile(depth=2000)
NODE = "/ur5_force"
TOPICS: dict[str, Any] = {
    "/joint_states": JointState,
    f"{NODE}/wrench": WrenchStamped,
    f"{NODE}/wrench_with_covariance": AccelWithCovarianceStamped,
    f"{NODE}/contact": DiagnosticArray,
}
READY = "ready"  # a file: a probe and its answers have reached the listener
FIRST, LAST = PROBES = 1_000_000, 1_000_001  # s, the stamps of a probe
PATIENCE = 120.0  # s, until all have found each other, or until the last answer


def spin_until(node: Any, condition: Any) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            sys.exit("nobody answers")
        rclpy.spin_once(node, timeout_sec=0.05)


def stamped(message: Any, seconds: int, nanoseconds: int) -> Any:
    message.header.stamp.sec, message.header.stamp.nanosec = seconds, nanoseconds
    return message


class Driver:
    """A driver, which also hears the answers of its nodes."""

    def __init__(self, kept: int) -> None:
        self.node, own = rclpy.create_node("driver"), QoSProfile(depth=kept)
        self.publisher = self.node.create_publisher(JointState, "joint_states", own)
        self.answers = Counter[tuple[int, int]]()
        self.node.create_subscription(WrenchStamped, f"{NODE}/wrench", self.hear, QOS)
        self.caller = self.node.create_client(Trigger, f"{NODE}/tare")
        self.probes = 0

    def hear(self, wrench: Any) -> None:
        self.answers[wrench.header.stamp.sec, wrench.header.stamp.nanosec] += 1

    def probe(self, seconds: int) -> tuple[int, int]:
        """Send what is no sample, but answered; return its stamp."""
        self.probes += 1
        message = JointState(name=["elbow_joint"], position=[0.0])
        self.publisher.publish(stamped(message, seconds, self.probes))
        return seconds, self.probes

    def find(self, nodes: int) -> None:
        """Probe until so many nodes answer, and the listener is ready."""
        asked, end = [self.probe(FIRST)], time.monotonic() + PATIENCE
        while max(self.answers[own] for own in asked) < nodes or not Path(READY).exists():
            if time.monotonic() > end:
                sys.exit("nobody was found")
            asked.append(self.probe(FIRST))
            rclpy.spin_once(self.node, timeout_sec=0.1)

    def heard_by(self, nodes: int) -> None:
        """Wait until nodes have answered all that was sent."""
        asked = self.probe(FIRST)
        spin_until(self.node, lambda: self.answers[asked] >= nodes)

    def send(self, row: dict[str, Any]) -> int:
        message = JointState(name=row["name"])
        message.position, message.velocity, message.effort = row["q"], row["qd"], row["effort"]
        sent = time.time_ns()
        self.publisher.publish(stamped(message, *row["stamp"]))
        return sent

    def tare(self) -> list[Any]:
        self.heard_by(1)
        future = self.caller.call_async(Trigger.Request())
        spin_until(self.node, future.done)
        return [future.result().success, future.result().message]


def publish(plan: str, rate: str, kept: str, nodes: str, done: str) -> None:
    """Send the messages of a plan. At `tare`, call the service; at [name, before, after], make a
    file of this name when `before` nodes have answered all, and go on when it is gone, and `after`
    answer.
    """
    driver, rows, sent = Driver(int(kept)), json.loads(Path(plan).read_text()), list[Any]()
    driver.find(int(nodes))
    spin_until(driver.node, driver.caller.service_is_ready)
    begin = time.monotonic()
    for k, row in enumerate(rows):
        time.sleep(max(0.0, begin + k / float(rate) - time.monotonic()))
        pauses = time.monotonic()
        if row == "tare":
            sent.append(driver.tare())
        elif isinstance(row, list):
            name, before, after = row
            driver.heard_by(before)
            Path(name).touch()
            spin_until(driver.node, lambda own=name: not Path(own).exists())
            driver.find(after)
        else:
            sent.append(driver.send(row))
            continue
        begin += time.monotonic() - pauses
    driver.probe(LAST)
    Path(done).write_text(json.dumps(sent))
    if not driver.publisher.wait_for_all_acked(Duration(seconds=PATIENCE)):
        sys.exit("samples were not received")


def took(got: Any, probed: Any, topic: str, raw: bytes, info: Any) -> None:
    """Keep a message, if it is not about a probe; a stamp's seconds follow four bytes of CDR."""
    seconds = int.from_bytes(raw[4:8], "little")
    if seconds in PROBES:
        probed[seconds, topic] += 1
    else:
        got[topic].append((info["received_timestamp"], raw))


def listen(file: str, nodes: str) -> None:
    node = rclpy.create_node("listener")
    got: dict[str, list[tuple[int, bytes]]] = {topic: [] for topic in TOPICS}
    probed = Counter[tuple[int, str]]()
    for topic, kind in TOPICS.items():
        take = partial(took, got, probed, topic)
        node.create_subscription(kind, topic, take, QOS, raw=True)
    spin_until(node, lambda: all(probed[FIRST, topic] for topic in TOPICS))
    Path(READY).touch()
    expected = {topic: int(nodes) for topic in TOPICS} | {"/joint_states": 1}
    spin_until(node, lambda: all(probed[LAST, own] >= count for own, count in expected.items()))
    Path(file).write_bytes(pickle.dumps(got))


if __name__ == "__main__":
    rclpy.init()
    {"publish": publish, "listen": listen}[sys.argv[1]](*sys.argv[2:])
    rclpy.try_shutdown()

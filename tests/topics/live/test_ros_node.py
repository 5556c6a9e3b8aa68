"""The ROS 2 node, between a publisher and a listener, each a process of its own on this computer.

ROS's Python comes from wheels (`ros-requirements.lock`), good for tests, not for a plant; NumPy is
that of ROS 2 Jazzy.
"""

import hashlib
import json
import os
import pickle
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import yaml
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from tests.command import Command
from tests.conftest import PROJECT
from tests.topics.live.made_arm import PERIOD, efforts_of, exported, samples
from ur5lib.commands.exported import ROS_NAMES
from ur5lib.records.measured import Measured
from ur5lib.topics.live.exports import NODE
from ur5lib.topics.live.live import FREE, UNKNOWN

HERE = Path(__file__).parent
LOCK, PROCESSES = HERE / "ros-requirements.lock", HERE / "ros_processes.py"
SOURCES = PROJECT / "ur5lib" / "topics" / "live"
STORE = get_typestore(Stores.ROS2_JAZZY)
KINDS = {
    "/joint_states": "sensor_msgs/msg/JointState",
    "/ur5_force/wrench": "geometry_msgs/msg/WrenchStamped",
    "/ur5_force/wrench_with_covariance": "geometry_msgs/msg/AccelWithCovarianceStamped",
    "/ur5_force/contact": "diagnostic_msgs/msg/DiagnosticArray",
}
WRENCH, SPREAD, CONTACT = [*KINDS][1:]
PATIENCE = 240.0  # s
ORDER = [3, 0, 5, 1, 4, 2]  # of the joints in a message
KILLS = 14  # of the node
NO_WHEELS = "ROS 2's Python cannot be installed here"
STEP = """
import json
from live import Live
arm = Live.load("arm.json")
answers = [arm.step(*sample) for sample in json.load(open("samples"))]
print(json.dumps([[one.wrench.tolist(), one.std.tolist(), one.contact] for one in answers]))
"""
Row = dict[str, Any]


@pytest.fixture(scope="session")
def ros_python() -> Path:
    """A Python with ROS 2, made once, of the wheels in the lock alone."""
    python = shutil.which("python3.11")
    if python is None or sys.platform != "linux":
        pytest.skip(f"{NO_WHEELS}: its wheels are for Python 3.11 on Linux")
    digest = hashlib.sha256(LOCK.read_bytes()).hexdigest()[:12]
    folder = PROJECT / ".pytest_cache" / f"ros-{digest}"
    if not (folder / "ready").is_file():
        subprocess.run([python, "-m", "venv", "--clear", folder], check=True)
        pip = [folder / "bin" / "python", "-m", "pip", "install", "--quiet", "--no-deps"]
        more = ["--require-hashes", "--only-binary", ":all:", "--no-compile", "-r", LOCK]
        done = subprocess.run([*pip, *more], capture_output=True, text=True)
        if done.returncode:
            pytest.skip(f"{NO_WHEELS}: {done.stderr.strip().splitlines()[-1]}")
        (folder / "ready").touch()
    return folder / "bin" / "python"


class Told(NamedTuple):
    """What a listener got: by topic, arrival times [ns], and messages."""

    times: dict[str, list[int]]
    messages: dict[str, list[Any]]
    raw: dict[str, list[tuple[int, bytes]]]

    def states(self) -> list[tuple[str, dict[str, str]]]:
        """The state of each answer, and its values."""
        return [(own.status[0].message, values_of(own)) for own in self.messages[CONTACT]]


def values_of(message: Any) -> dict[str, str]:
    return {pair.key: pair.value for pair in message.status[0].values}


class Ros:
    """Processes of ROS on this computer alone, and what they write."""

    def __init__(self, python: Path, folder: Path) -> None:
        self.python, self.folder = python, folder
        own = {
            "ROS_DOMAIN_ID": str(os.getpid() % 100),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",  # as the profile says
            "FASTDDS_DEFAULT_PROFILES_FILE": str(HERE / "ros_local.xml"),
            "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
            "OMP_NUM_THREADS": "1",
            "ROS_LOG_DIR": str(folder / "log"),
        }
        self.environment = os.environ | own
        self.processes: list[subprocess.Popen[str]] = []

    def start(self, *command: object) -> "subprocess.Popen[str]":
        process = subprocess.Popen(
            [self.python, *map(str, command)], env=self.environment, cwd=self.folder, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        self.processes.append(process)
        return process

    def node(self, arm: Row, *parameters: str) -> "subprocess.Popen[str]":
        """Start the node in a folder as `ur5 export --format ros2` writes it."""
        for name, own in NODE.items():
            shutil.copy(SOURCES / own, self.folder / name)
        (self.folder / "arm.json").write_text(json.dumps(arm))
        given = [part for one in parameters for part in ("-p", one)]
        return self.start("ur5_force.py", "--ros-args", *given)

    def listen(self, nodes: int = 1) -> "subprocess.Popen[str]":
        """Start to hear messages, until a driver has ended and so many nodes have answered all."""
        return self.start(PROCESSES, "listen", "heard", nodes)

    def driver(
        self, rows: list[Any], rate: float = 125.0, nodes: int = 1, kept: int = 2000
    ) -> "subprocess.Popen[str]":
        """Start to publish messages, of which it keeps some until they have arrived; other rows are
        commands, as `ros_processes` takes them.
        """
        (self.folder / "plan").write_text(json.dumps(rows))
        return self.start(PROCESSES, "publish", "plan", rate, kept, nodes, "sent")

    @contextmanager
    def paused(self, name: str) -> Iterator[None]:
        """Wait until a driver pauses; it goes on afterwards."""
        self.wait_for(name)
        yield
        (self.folder / name).unlink()

    def wait_for(self, name: str) -> None:
        """Wait until a process has made a file."""
        end = time.monotonic() + PATIENCE
        while not (self.folder / name).exists():
            assert time.monotonic() < end
            time.sleep(0.05)

    def sent(self, done: "subprocess.Popen[str]") -> list[Any]:
        """When each message was published, or the answer to a call."""
        out, _ = done.communicate(timeout=PATIENCE)
        assert done.returncode == 0, out
        return json.loads((self.folder / "sent").read_text())

    def heard(self, listener: "subprocess.Popen[str]") -> Told:
        out, _ = listener.communicate(timeout=PATIENCE)
        assert listener.returncode == 0, out
        raw = pickle.loads((self.folder / "heard").read_bytes())
        messages = {
            topic: [STORE.deserialize_cdr(own, KINDS[topic]) for _, own in found]
            for topic, found in raw.items()
        }
        messages[CONTACT] = [  # without what the node says of silence, by itself
            own for own in messages[CONTACT] if "no joint_states" not in values_of(own)["reason"]
        ]
        return Told({topic: [t for t, _ in own] for topic, own in raw.items()}, messages, raw)

    def open_to_others(self) -> list[str]:
        """The local addresses of sockets that are not bound to 127.0.0.1."""
        inodes = set[str]()
        for process in self.processes:
            for one in Path(f"/proc/{process.pid}/fd").glob("*"):
                with suppress(OSError):
                    inodes.add(os.readlink(one).removeprefix("socket:[").removesuffix("]"))
        rows = [
            line.split()
            for kind in ("udp", "udp6", "tcp", "tcp6")
            for line in Path("/proc/net", kind).read_text().splitlines()[1:]
        ]
        own = [row[1] for row in rows if row[9] in inodes]
        assert own
        return [address for address in own if not address.startswith("0100007F:")]

    def end(self) -> None:
        for process in self.processes:
            process.kill()
            process.communicate()


@pytest.fixture
def ros(ros_python: Path, tmp_path: Path) -> Iterator[Ros]:
    running = Ros(ros_python, tmp_path)
    yield running
    running.end()


def arm() -> Row:
    return exported() | {"arm": "ur5", "joints": ROS_NAMES}


def row(time: float, q: Any, qd: Any, effort: Any) -> Row:
    """A message as a driver sends it: joints in another order, among them a gripper's."""
    names = [*np.array(ROS_NAMES)[ORDER].tolist(), "finger_joint"]
    q, qd, effort = (np.append(np.take(own, ORDER), 0.5).tolist() for own in (q, qd, effort))
    stamp = [*map(int, divmod(round(1e9 * time), 10**9))]
    return {"stamp": stamp, "name": names, "q": q, "qd": qd, "effort": effort}


def rows_of(run: Measured) -> list[Row]:
    return [row(*own) for own in zip(run.time, run.q, run.qd, run.current, strict=True)]


def in_order(message: Any, field: str) -> Any:
    return np.array([getattr(message, field)[[*message.name].index(own)] for own in ROS_NAMES])


def expected_of(ros: Ros, messages: list[Any]) -> list[Any]:
    """What `step` answers to the messages that were heard, by its NumPy: wrench, std, state."""
    samples = [
        [
            one.header.stamp.sec + 1e-9 * one.header.stamp.nanosec,
            *(in_order(one, field).tolist() for field in ("position", "velocity", "effort")),
        ]
        for one in messages
    ]
    (ros.folder / "samples").write_text(json.dumps(samples))
    out, _ = ros.start("-c", STEP).communicate(timeout=PATIENCE)
    return json.loads(out)


def check_answers(ros: Ros, told: Told, sent: list[int], count: int) -> None:
    """None is lost, all are those of `step` to the bit; prints the times of answers."""
    assert {topic: len(own) for topic, own in told.messages.items()} == dict.fromkeys(KINDS, count)
    stamps = [
        [(m.header.stamp.sec, m.header.stamp.nanosec) for m in told.messages[t]] for t in KINDS
    ]
    assert all(own == stamps[0] for own in stamps)
    for own, both, state, (wrench, std, contact) in zip(
        *(told.messages[topic] for topic in (WRENCH, SPREAD, CONTACT)),
        expected_of(ros, told.messages["/joint_states"]),
        strict=True,
    ):
        for first, second in (
            (own.wrench.force, own.wrench.torque),
            (both.accel.accel.linear, both.accel.accel.angular),
        ):
            assert [first.x, first.y, first.z, second.x, second.y, second.z] == wrench
        np.testing.assert_array_equal(both.accel.covariance, np.diag(np.square(std)).ravel())
        assert {own.header.frame_id, both.header.frame_id} == {"base"}
        assert state.status[0].message == contact
    late = 1e-6 * (np.array(told.times[WRENCH]) - sent)
    median, slow = np.quantile(late, [0.5, 0.99])
    print(f"{count} messages: wrench after {median:.2f} ms (median), {slow:.2f} ms (99 %)")


def replayed(ros: Ros, count: int, rate: float, kept: int = 2000) -> Told:
    ros.node(arm())
    listener = ros.listen()
    driver = ros.driver(rows_of(samples(count * PERIOD, True)), rate, kept=kept)
    sent = ros.sent(driver)
    assert ros.open_to_others() == []
    told = ros.heard(listener)
    check_answers(ros, told, sent, count)
    return told


def test_messages_are_answered_as_step_answers_them(
    ros: Ros, tmp_path: Path, run_ur5: Command
) -> None:
    """And no socket of them is open to other computers; a bag of them opens by our own door."""
    told = replayed(ros, 250, 125.0)
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        for topic, kind in KINDS.items():
            own = bag.add_connection(topic, kind, typestore=STORE)
            for arrived, raw in told.raw[topic]:
                bag.write(own, arrived, raw)
    study = tmp_path / "study.yaml"
    answer = run_ur5("import", tmp_path / "bag", "--robot", "ur5", "--output", study)
    assert answer.status == 0, answer.err
    [entry] = yaml.safe_load(study.read_text())["recordings"]
    assert entry["channels"]["actual_q"] == "/joint_states/position"
    assert "/ur5_force/wrench" in answer.out + study.read_text()


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.parametrize("rate", [125.0, 500.0])
def test_none_of_a_thousand_messages_is_lost(rate: float, ros: Ros) -> None:
    """By a driver that keeps one message, as joint_state_broadcaster does on Fast DDS."""
    replayed(ros, 1000, rate, kept=1)


@pytest.mark.thorough
def test_a_node_that_stands_still_loses_nothing_that_its_driver_keeps(ros: Ros) -> None:
    node, rows = ros.node(arm()), rows_of(samples(500 * PERIOD, True))
    listener, driver = ros.listen(), ros.driver([*rows[:100], ["stop", 1, 0], *rows[100:]], 500.0)
    with ros.paused("stop"):
        node.send_signal(signal.SIGSTOP)
    ros.wait_for("sent")
    node.send_signal(signal.SIGCONT)
    sent = [own for own in ros.sent(driver) if isinstance(own, int)]
    check_answers(ros, ros.heard(listener), sent, len(rows))


def without(row: Row, name: str) -> Row:
    kept = [k for k, own in enumerate(row["name"]) if own != name]
    lists = {key: [row[key][k] for k in kept] for key in ("name", "q", "qd", "effort")}
    return row | lists


def test_each_fault_of_the_stream_has_its_state_and_reason(ros: Ros) -> None:
    rows = rows_of(samples(12.0, True))
    part = lambda first, last: rows[round(first / PERIOD) : round(last / PERIOD)]  # noqa: E731
    nan = [np.nan] * 7
    gripper = {"name": ["finger_joint"], "q": [0.5], "qd": [0.0], "effort": [0.1]}
    parts: list[tuple[list[Any], str, str]] = [
        (part(0, 2), FREE, ""),
        ([without(own, "elbow_joint") for own in part(2, 2.2)], UNKNOWN, "lacks elbow_joint"),
        (part(2.2, 4.2), FREE, ""),
        ([own | {"q": nan} for own in part(4.2, 4.4)], UNKNOWN, "no usable sample"),
        (part(4.4, 5.9), FREE, ""),
        ([own | {"qd": nan} for own in part(5.9, 6)], FREE, ""),
        ([own | gripper for own in part(6, 6.05)], FREE, ""),
        (part(1, 1.5), UNKNOWN, "has just begun"),  # its clock jumps back
        (part(1.5, 3), FREE, ""),
        ([own | {"effort": nan} for own in part(3, 3.2)], UNKNOWN, "states no effort"),
        (part(3.2, 5.2), FREE, ""),
        (["tare", *part(5.2, 5.7)], UNKNOWN, "has just begun"),
        (part(5.7, 7), FREE, ""),
    ]
    ros.node(arm())
    plan = [row for own, *_ in parts for row in own]
    listener = ros.listen()
    sent = ros.sent(ros.driver(plan))
    states, end = ros.heard(listener).states(), 0
    for own, state, reason in parts:
        end += len([row for row in own if row != "tare" and row["name"] != ["finger_joint"]])
        word, values = states[end - 1]
        assert (word, reason in values["reason"]) == (state, True), (own[-1], values)
        assert bool(reason) == bool(values["reason"])
        assert 0 <= float(values["probability"]) <= 1
    assert end == len(states)
    done, message = next(own for own in sent if isinstance(own, list))
    assert done == ("is its background" in message)  # a busy machine may be silent before


def test_efforts_of_another_kind_are_refused(ros: Ros, tmp_path: Path) -> None:
    """By the parameter at once, else after a second of motion."""
    out, _ = ros.node(arm(), "input:=torque").communicate(timeout=60)
    assert "currents [A] are expected" in out
    assert "Traceback" not in out
    out, _ = ros.node(arm(), "input:=5").communicate(timeout=60)
    assert "'input' to '5' of type 'INTEGER', expecting type 'STRING'" in out
    assert "Traceback" not in out
    run = samples(3.0, True)
    ros.node(arm())
    listener = ros.listen()
    ros.sent(ros.driver(rows_of(run._replace(current=efforts_of(run, "torque")))))
    word, values = ros.heard(listener).states()[-1]
    assert word == UNKNOWN
    assert "torques [Nm], but currents [A] are expected; let the driver" in values["reason"]


@pytest.mark.thorough
def test_a_killed_node_is_followed_by_the_next_and_a_second_one_is_told(ros: Ros) -> None:
    """Two at once; one is killed, and started again; none of them loses a message."""
    rows, part = rows_of(samples(600 * PERIOD, True)), 200
    plan = [*rows[:part], ["two", 2, 1], *rows[part : 2 * part], ["one", 1, 2], *rows[2 * part :]]
    first, _ = ros.node(arm()), ros.node(arm())
    listener, driver = ros.listen(2), ros.driver(plan, nodes=2)
    with ros.paused("two"):
        first.send_signal(signal.SIGKILL)
        first.wait()
    with ros.paused("one"):
        ros.node(arm())
    ros.sent(driver)
    told = ros.heard(listener)
    answers = Counter((m.header.stamp.sec, m.header.stamp.nanosec) for m in told.messages[CONTACT])
    stamps = [tuple(own["stamp"]) for own in rows]
    assert [answers[own] for own in stamps] == [2] * part + [1] * part + [2] * part
    assert any("nodes publish /ur5_force/wrench" in own["beside"] for _, own in told.states())
    assert {word for word, _ in told.states()[-2:]} == {FREE}


@pytest.mark.thorough
def test_of_a_node_that_is_killed_at_any_moment_no_answer_is_lost(ros: Ros) -> None:
    """While it starts, or answers; each time the next one takes over."""
    random, part = np.random.default_rng(0), 100
    rows = rows_of(samples(KILLS * part * PERIOD, True))
    rounds = [rows[k * part : (k + 1) * part] for k in range(KILLS)]
    node, listener = ros.node(arm()), ros.listen()
    plan = [row for k, own in enumerate(rounds) for row in (*own, [f"round {k}", 0, 1])]
    driver = ros.driver(plan)
    for k in range(KILLS):
        time.sleep(random.uniform(0.0, 3.0))
        node.kill()
        node.wait()
        node = ros.node(arm())
        with ros.paused(f"round {k}"):
            pass
    ros.sent(driver)
    told = ros.heard(listener)
    stamps = {(*own["stamp"],): k for k, own in enumerate(rows)}
    found = {
        topic: [stamps[m.header.stamp.sec, m.header.stamp.nanosec] for m in told.messages[topic]]
        for topic in (WRENCH, SPREAD, CONTACT)
    }
    for own in found.values():
        assert np.count_nonzero(np.diff(own) != 1) <= KILLS
        assert len({*own}) == len(own) >= len(rows) / 2
        assert len({*found[WRENCH]} ^ {*own}) <= KILLS  # killed between two topics

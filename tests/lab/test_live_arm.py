"""The live arm moves as its commands say, and its controller survives any client."""

import random
import socket
import struct
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from ur5lab.doubles import urscript_programs
from ur5lab.doubles.control_box import ControlBox
from ur5lab.doubles.controller_double import ControllerDouble, Ports
from ur5lab.doubles.dashboard_server import answer
from ur5lab.doubles.device_double import DeviceClock
from ur5lab.doubles.live_arm import LiveArm, TargetGenerator
from ur5lab.doubles.true_states import TrueStates, force_reading, imu_reading
from ur5lab.recorder.rtde_arm import RtdeClient
from ur5lab.rtde_variables import RuntimeState, SafetyMode
from ur5lib.robots.description import Robot
from ur5lib.stand.plan import POSTURE, ForceSensor, Imu, SimulatedRecording, Spring
from ur5lib.stand.rig import STEP
from ur5lib.timeseries.arrays import Array

HERE = "127.0.0.1"
HOME = np.array(POSTURE)
GOAL = np.add(POSTURE, [0.4, -0.2, 0.1, 0.0, 0.3, -0.1])
PLAN = SimulatedRecording.model_validate({"trajectory": {"kind": "standstill"}, "noise": False})


def run(motion: TargetGenerator, most: int = 5000) -> Array:
    """Targets (N, 3, 6) until the command ends."""
    rows = []
    while motion.moving and len(rows) < most:
        rows.append(motion.step())
    return np.array(rows)


@pytest.fixture
def box(tmp_path: Path, ur5e: Robot) -> Iterator[ControlBox]:
    with (tmp_path / "states").open("wb") as file:
        arm = LiveArm(ur5e, PLAN, file, np.random.default_rng(0))
        yield ControlBox(arm, (5, 11, 1, 0), 0.002, 100.0, np.random.default_rng(1))


@pytest.fixture
def truth(box: ControlBox, tmp_path: Path) -> TrueStates:
    return TrueStates(tmp_path / "states", DeviceClock())


def execute(box: ControlBox, *lines: str, cycles: int = 2000) -> list[str]:
    """What the log says while a program runs."""
    said: list[str] = []
    box.log.append(said.append)
    box.run(urscript_programs.program(lines, box))
    for _ in range(cycles):
        if box.state != RuntimeState.PLAYING and not box.arm.motion.moving:
            break
        box.advance()
    return said


# Motion commands


def test_movej_arrives_with_all_joints_at_once() -> None:
    motion = TargetGenerator(HOME)
    motion.movej(GOAL, 0.5, 2.0)
    q, qd, qdd = run(motion).transpose(1, 0, 2)
    np.testing.assert_allclose(q[-2:], [GOAL] * 2, atol=1e-12)
    assert np.abs(qd).max() == pytest.approx(0.5)
    assert np.abs(qdd).max() == pytest.approx(2.0)
    np.testing.assert_allclose(np.diff(q, axis=0), STEP * (qd[1:] + qd[:-1]) / 2, atol=3e-6)
    moving = np.abs(qd) > 0
    assert (moving[:, 0] == moving[:, 4]).all()


def test_stopj_brakes_with_the_deceleration_asked_for() -> None:
    motion = TargetGenerator(HOME)
    motion.speedj(np.array([0.5, -0.25, 0, 0, 0, 0]), 1.0)
    for _ in range(1000):
        motion.step()
    np.testing.assert_allclose(motion.qd[:2], [0.5, -0.25])
    motion.stopj(2.0)
    _, qd, qdd = run(motion).transpose(1, 0, 2)
    assert len(qd) == pytest.approx(0.25 / STEP, abs=2)
    np.testing.assert_allclose(qdd[:-1, :2], [[-2.0, 1.0]] * (len(qd) - 1))
    assert (qd[-1] == 0).all()


def test_servoj_lags_by_its_lookahead() -> None:
    motion = TargetGenerator(HOME)
    for k in range(3000):
        motion.servoj(HOME + 0.2 * STEP * k, 0.1)
        motion.step()
    np.testing.assert_allclose(HOME + 0.2 * STEP * 3000 - motion.q, 0.02, rtol=0.02)
    np.testing.assert_allclose(motion.qd, 0.2, rtol=1e-3)


def test_a_new_movej_brakes_first() -> None:
    motion = TargetGenerator(HOME)
    motion.movej(GOAL, 0.5, 2.0)
    for _ in range(300):
        motion.step()
    motion.movej(HOME, 0.5, 2.0)
    rows = run(motion)
    assert np.abs(np.diff(rows[:, 1], axis=0)).max() < 2.1 * STEP  # no jump of the speed
    np.testing.assert_allclose(rows[-2, 0], HOME, atol=1e-12)


# Programs


def test_a_program_of_plain_commands_runs_to_its_end(box: ControlBox) -> None:
    said = execute(
        box,
        "def program():",
        '  textmsg("away")  # a remark',
        f"  movej({GOAL.tolist()}, a=4, v=2)",
        f"  movej({HOME.tolist()}, t=0.5)",
        f"  servoj({HOME.tolist()}, 0, 0, 0.1, 0.05, 300)",
        "  set_payload(1.2, [0, 0, 0.1])",
        "  sleep(0.02)",
        "  write_output_integer_register(3, 7)",
        "end",
    )
    assert said == ["away"]
    assert box.state == RuntimeState.STOPPED
    np.testing.assert_allclose(box.outputs["actual_q"], HOME, atol=2e-3)
    assert (box.outputs["payload"], box.outputs["output_int_register_3"]) == (1.2, 7)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("movel([0.1, 0.2, 0.3, 0, 0, 0], 1, 1)", "movel() is not emulated"),
        ("movej(p[0.1, 0.2, 0.3, 0, 0, 0], 1, 1)", "`movej(p[0.1, 0.2, 0.3, 0, 0, 0], 1, 1)`"),
        ("movej([1, 2, 3])", "[1, 2, 3] instead of six joint values"),
        ("movej([1, 2, 3, 4, 5, 'x'])", "instead of six joint values"),
        ("movej([1, 2, 3, 4, 5, 6], speed=1)", "arguments of movej"),
        ("movej([0, 0, 0, 0, 0, 0], a=0, v=1)", "must be positive"),
        ("movej([0, 0, 0, 0, 0, 0], a=1, v='fast')", "not supported between"),
        ("servoj([0, 0, 0, 0, 0, 0], lookahead_time=0)", "must be positive"),
        ("set_payload(-1)", "greater than 0"),
        ("freedrive_mode(freeAxes=[1, 0, 0, 0, 0, 0])", "some axes only"),
        ("while True:", "`while True:` is not emulated"),
        ("x = 1", "`x = 1` is not emulated"),
    ],
)
def test_what_is_not_emulated_is_said_and_ends_the_program(
    box: ControlBox, line: str, said: str
) -> None:
    [message] = execute(box, line, "sleep(10)")
    assert message.startswith("Runtime error: ")
    assert said in message
    assert box.state == RuntimeState.STOPPED
    np.testing.assert_array_equal(box.arm.motion.q, HOME)


def test_a_protective_stop_brakes_and_refuses_programs(box: ControlBox) -> None:
    said = execute(box, "speedj([1, 0, 0, 0, 0, 0], 5, 1)", "protective_stop()", "sleep(9)")
    assert said == ["Protective stop: commanded by the program"]
    assert box.safety_mode == SafetyMode.PROTECTIVE_STOP
    assert box.outputs["safety_status_bits"] == 4
    np.testing.assert_array_equal(box.arm.motion.qd, 0)
    assert execute(box, "sleep(1)") == ["the robot is not ready: the program is not started"]
    assert answer("unlock protective stop", box) == "Protective stop releasing"
    assert execute(box, "sleep(0.1)") == []


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("speedj([9, 0, 0, 0, 0, 0], 100, 5)", "speed limit of joint 1"),
        ("movej([0.5, -1.6, 1.6, -1.5, 1.5, 8], 20, 3)", "position limit of joint 6"),
    ],
)
def test_a_limit_that_is_exceeded_stops_the_arm(box: ControlBox, line: str, reason: str) -> None:
    assert execute(box, line, cycles=5000)[0] == f"Protective stop: {reason}"
    assert not box.arm.motion.moving


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("robotmode", "Robotmode: RUNNING"),
        ("safetystatus", "Safetystatus: NORMAL"),
        ("programState", "STOPPED <unnamed>"),
        ("get loaded program", "No program loaded"),
        ("play", "Failed to execute: play"),
        ("pause", "Failed to execute: pause"),
        ("running", "Program running: false"),
        ("is in remote control", "true"),
        ("load a.urp", "Loading program: a.urp"),
        ("dance", "could not understand: 'dance'"),
    ],
)
def test_the_dashboard_knows_its_commands(box: ControlBox, command: str, told: str) -> None:
    assert answer(command, box) == told


# By hand


def pull(box: ControlBox, seconds: float) -> None:
    """A hand at the tool, on a spring that moves 10 cm away and back."""
    start = box.arm.time
    box.arm.touch(
        Spring(kind="spring", displacement=(0.0, 0.1, 0.0), start_s=start, seconds=seconds)
    )


def test_in_freedrive_the_arm_gives_way_and_then_stays(box: ControlBox) -> None:
    """Where nobody pulls, its weight does not move it."""
    assert execute(box, "teach_mode()", "sleep(1.0)", "end_teach_mode()") == []
    np.testing.assert_allclose(box.arm.states["q"][-1], HOME, atol=0.005)
    pull(box, 2.0)
    execute(box, "sleep(1.0)")
    np.testing.assert_allclose(box.arm.states["q"][-1], HOME, atol=0.01)
    pull(box, 2.0)
    assert execute(box, "freedrive_mode()", "sleep(1.0)", "end_freedrive_mode()") == []
    led = box.arm.states["q"][-1].copy()
    assert np.abs(led - HOME).max() > 0.05
    assert box.safety_mode == SafetyMode.NORMAL
    execute(box, "sleep(1.5)")  # while the hand goes back
    np.testing.assert_allclose(box.arm.states["q"][-1], led, atol=0.01)


# Sensors


def test_sensors_read_the_truth_with_their_bias(box: ControlBox, truth: TrueStates) -> None:
    for _ in range(50):
        box.advance()
    force = force_reading(truth, ForceSensor(), seed=None)(0.05)
    np.testing.assert_allclose(force - ForceSensor().bias, truth.part("force_sensor", 0.05))
    read = imu_reading(truth, Imu(), 250.0, seed=None)
    imu = np.array([read(k * 0.004) for k in range(10)])
    still = imu[:, :3] - Imu().accelerometer_bias
    np.testing.assert_allclose(np.linalg.norm(still, axis=1), 9.81, atol=0.02)
    np.testing.assert_allclose(imu[:, 3:6], [Imu().gyroscope_bias] * 10, atol=0.01)
    np.testing.assert_allclose(np.linalg.norm(imu[:, 6:], axis=1), 0.8, atol=0.01)
    read = imu_reading(truth, Imu(), 250.0)
    noisy = np.array([read(k * 0.004) for k in range(10)])
    assert noisy.std(axis=0).min() > 0


def test_the_truth_is_kept_from_its_beginning_to_its_end(
    box: ControlBox, truth: TrueStates
) -> None:
    """And interpolated between steps."""
    box.arm.motion.movej(GOAL, 1.0, 40.0)
    for _ in range(10):
        box.advance()
    states = truth.states()
    assert len(states) == 21  # the first step is that of the start
    np.testing.assert_array_equal(states["q"][-5:], box.arm.states["q"])
    np.testing.assert_array_equal(truth.states(1, 4)["imu"], states["imu"][1:4])
    q = truth.part("q", np.array([0.004, 0.0045, 0.005]))
    np.testing.assert_array_equal(q[::2], states["q"][4:6])
    np.testing.assert_allclose(q[1], (q[0] + q[2]) / 2)
    np.testing.assert_array_equal(truth.part("q", 1e9), states["q"][-1])
    assert truth.latest() == pytest.approx(0.020)


# RTDE, by hand


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    ports = Ports.free()
    with ControllerDouble("ur5", ports=ports):
        yield ports.rtde


def ask(connection: socket.socket, kind: str, content: bytes = b"") -> bytes:
    connection.sendall(struct.pack(">HB", 3 + len(content), ord(kind)) + content)
    size, answered = struct.unpack(">HB", connection.recv(3, socket.MSG_WAITALL))
    assert answered == ord(kind)
    return connection.recv(size - 3, socket.MSG_WAITALL)


def test_rtde_answers_as_its_guide_says(port: int) -> None:
    with (
        socket.create_connection((HERE, port)) as one,
        socket.create_connection((HERE, port)) as two,
    ):
        assert ask(one, "V", b"\0\3") == b"\0"
        assert ask(one, "V", b"\0\2") == b"\1"
        assert struct.unpack(">4I", ask(one, "v")) == (3, 15, 8, 106339)
        wanted = b"timestamp,actual_q,joint_mode,ft_raw_wrench,nonsense"
        kinds = ask(one, "O", struct.pack(">d", 125) + wanted)[1:]
        assert kinds == b"DOUBLE,VECTOR6D,VECTOR6INT32,NOT_FOUND,NOT_FOUND"
        assert ask(one, "S") == b"\0"
        assert ask(one, "I", b"input_int_register_0,input_double_register_5") == (b"\1INT32,DOUBLE")
        assert ask(one, "I", b"input_int_register_0,nonsense") == b"\0INT32,NOT_FOUND"
        assert ask(two, "I", b"input_int_register_0") == b"\0IN_USE"
        assert ask(two, "O", b"timestamp,robot_mode") == b"DOUBLE,INT32"  # version 1
        assert ask(two, "S") == b"\1"
        size, kind = struct.unpack(">HB", two.recv(3, socket.MSG_WAITALL))
        assert (size, kind) == (3 + 12, ord("U"))


def test_no_bytes_bring_the_controller_down(port: int) -> None:
    """Nonsense, and packages that are damaged; afterwards it answers as before."""
    draw = random.Random(1)
    whole = struct.pack(">HBd", 20, ord("O"), 125.0) + b"timestamp"
    for k in range(300):
        data = bytearray(draw.randbytes(40) if k % 2 else whole)
        data[draw.randrange(len(data))] = draw.randrange(256)
        with socket.create_connection((HERE, port)) as connection:
            connection.sendall(data)
    client = RtdeClient(HERE, port)
    assert client.start(["timestamp"], 125.0) == ["timestamp"]
    until = time.monotonic() + 30
    stamps: list[float] = []
    while len(stamps) < 10 and time.monotonic() < until:
        stamps += [numbers[0] for _, numbers in client.receive(1.0)]
    client.close()
    np.testing.assert_allclose(np.diff(stamps), 0.008, atol=1e-9)

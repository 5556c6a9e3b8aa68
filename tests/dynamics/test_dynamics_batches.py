"""How the equations are evaluated: in batches, plain and fused, in both precisions, on a GPU."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch import Tensor

from tests.conftest import PROJECT
from tests.dynamics.test_dynamics import states
from tests.robots.test_from_urdf import made_up, saved
from ur5lib.dynamics import arm as batches
from ur5lib.dynamics.arm import ArmTensors, build_arm
from ur5lib.dynamics.kinematics import acceleration
from ur5lib.dynamics.rigid_body import (
    coriolis_matrix,
    forward_dynamics,
    gravity_torque,
    inertia_matrix,
    inverse_dynamics,
    kinetic_energy,
    potential_energy,
    regressor,
)
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.from_urdf import robot_from_urdf


@pytest.fixture(scope="module")
def arm(ur5: Robot) -> ArmTensors:
    return build_arm(ur5, "C+rotors")


def terms(arm: ArmTensors, q: Tensor, qd: Tensor, qdd: Tensor) -> dict[str, Tensor]:
    return {
        "torque": inverse_dynamics(arm, q, qd, qdd),
        "pushed": inverse_dynamics(arm, q, qd, qdd, qdd),
        "inertia": inertia_matrix(arm, q),
        "coriolis": coriolis_matrix(arm, q, qd),
        "gravity": gravity_torque(arm, q),
        "forward": forward_dynamics(arm, q, qd, qdd),
        "kinetic": kinetic_energy(arm, q, qd),
        "potential": potential_energy(arm, q),
        "regressor": regressor(arm, q, qd, qdd),
        "acceleration": acceleration(arm, q, qd, qdd),
    }


@pytest.mark.parametrize("count", [0, 1, 7, 64, 65])
def test_batches_change_nothing(
    arm: ArmTensors, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    q, qd, qdd = states(count)
    whole = terms(arm, q, qd, qdd)
    monkeypatch.setattr(batches, "CPU_BATCH", 8)
    for name, part in terms(arm, q, qd, qdd).items():
        assert part.shape == whole[name].shape
        assert part.is_contiguous() or name in ("pushed", "acceleration")
        torch.testing.assert_close(part, whole[name], rtol=0, atol=1e-10)


def test_wrong_states_are_refused(arm: ArmTensors) -> None:
    q, qd, qdd = states(3)
    with pytest.raises(ValueError, match=r"must be \(N, 6\).*\(2, 6\)"):
        inverse_dynamics(arm, q, qd[:2], qdd)
    with pytest.raises(ValueError, match=r"must be \(N, 6\).*\(6,\)"):
        gravity_torque(arm, q[0])
    with pytest.raises(ValueError, match=r"torch\.float64, not .*float32"):
        gravity_torque(arm, q.float())


def printed(program: str, **settings: str) -> str:
    """What a program prints in a process of its own, with these settings of its environment."""
    command = [sys.executable, "-c", program]
    done = subprocess.run(
        command, cwd=PROJECT, env=os.environ | settings, text=True, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_memory_does_not_grow_with_samples() -> None:
    """Beyond the result itself, whose 48 bytes a sample are counted off."""
    program = """
import resource, torch
from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.robots.description import load_robot, robot_path
arm = build_arm(load_robot(robot_path("ur5")), "C")
def peak(count):
    state = torch.zeros(1, 6, dtype=torch.float64).expand(count, 6)
    inverse_dynamics(arm, state, state, state)
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024 - 48e-6 * count
print(peak(1_000_000) - peak(100_000))
"""
    assert float(printed(program, OMP_NUM_THREADS="1")) < 20  # MiB


def test_gradients_reach_states_and_parameters(arm: ArmTensors) -> None:
    given = [state.requires_grad_() for state in states(3)]
    parameters = arm.parameters.clone().requires_grad_()
    assert torch.autograd.gradcheck(
        lambda pi, *state: inverse_dynamics(replace(arm, parameters=pi), *state),
        (parameters, *given),
        atol=1e-6,
        rtol=1e-6,
    )


def test_slope_in_the_parameters_is_the_regressor(arm: ArmTensors) -> None:
    given = states(5)
    slope = torch.func.jacrev(lambda pi: inverse_dynamics(replace(arm, parameters=pi), *given))
    torch.testing.assert_close(slope(arm.parameters), regressor(arm, *given))


# Single precision


@pytest.mark.parametrize(("name", "model"), [("ur5", "C"), ("ur5", "C+rotors"), ("ur10e", "maker")])
def test_single_precision_has_the_error_it_states(name: str, model: str) -> None:
    robot = load_robot(robot_path(name))
    double, single = build_arm(robot, model), build_arm(robot, model, dtype=torch.float32)
    q, qd, qdd = states()
    for term, given in (
        (inverse_dynamics, (q, qd, qdd)),
        (forward_dynamics, (q, qd, qdd)),
        (coriolis_matrix, (q, qd)),
        (inertia_matrix, (q,)),
    ):
        exact, rounded = term(double, *given), term(single, *(state.float() for state in given))
        assert rounded.dtype == torch.float32
        assert (rounded - exact).abs().max() < 1e-6 * exact.abs().max()


# Fused


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """The URDF of an arm of two joints, whose axes are at any angle: compiled in seconds."""
    return saved(made_up(2), tmp_path)


def test_fused_and_plain_give_the_same(small: Path) -> None:
    robot, model = robot_from_urdf(small)[0], "maker"
    plain, fused = (build_arm(robot, model, fused=own) for own in (False, True))
    given = [state[:, :2] for state in states(20_000)]
    torch.testing.assert_close(
        inverse_dynamics(fused, *given), inverse_dynamics(plain, *given), rtol=0, atol=1e-11
    )


def test_without_a_compiler_the_plain_program_is_used(small: Path) -> None:
    program = f"""
import torch, warnings
from pathlib import Path
from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.rigid_body import gravity_torque
from ur5lib.robots.from_urdf import robot_from_urdf
robot, _ = robot_from_urdf(Path({str(small)!r}))
q = torch.ones(5, 2, dtype=torch.float64)
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    fused = [gravity_torque(build_arm(robot, "maker", fused=True), q) for _ in range(2)]
assert len([one for one in told if "not fused" in str(one.message)]) == 1, told
assert all(torch.equal(torque, gravity_torque(build_arm(robot, "maker"), q)) for torque in fused)
"""
    printed(program, CXX="/no/compiler", TORCHINDUCTOR_FORCE_DISABLE_CACHES="1")


# GPU


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU is at hand")
def test_a_gpu_gives_the_same(ur5: Robot, arm: ArmTensors) -> None:
    there = [state.cuda() for state in states()]
    on_gpu = terms(build_arm(ur5, "C+rotors", device="cuda"), *there)
    for name, expected in terms(arm, *states()).items():
        assert on_gpu[name].is_cuda
        torch.testing.assert_close(on_gpu[name].cpu(), expected, rtol=1e-9, atol=1e-9)
    fused = inverse_dynamics(build_arm(ur5, "C+rotors", device="cuda", fused=True), *there)
    torch.testing.assert_close(fused, on_gpu["torque"], rtol=0, atol=1e-9)

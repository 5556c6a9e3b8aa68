"""An arm under one of its link models, as tensors."""

from dataclasses import dataclass
from xml.etree import ElementTree

import pytorch_kinematics as pk
import torch
from torch import Tensor

from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.urdf import urdf


@dataclass(frozen=True)
class Arm:
    """What the equations of motion need; frames are the Denavit-Hartenberg frames.

    links: kinematic chains from the base to frame k, k = 1 to 6;
    mass: (6,) [kg]; center_of_mass: (6, 3) [m] in frame k;
    inertia: (6, 3, 3) [kg m²] about the centre of mass, axes of frame k;
    gravity: (3,) [m/s²] in the base frame.
    """

    links: tuple[pk.SerialChain, ...]
    mass: Tensor
    center_of_mass: Tensor
    inertia: Tensor
    gravity: Tensor


def build_arm(
    robot: Robot, model: str, dtype: torch.dtype = torch.float64, device: str = "cpu"
) -> Arm:
    """An arm under one of its models, e.g. "A", "B" or "C"."""
    bodies = rigid_bodies(robot, model)
    chain = read_urdf(urdf(robot, bodies), dtype)

    def tensor(values: object) -> Tensor:
        return torch.as_tensor(values, dtype=dtype, device=device)

    return Arm(
        links=tuple(
            pk.SerialChain(chain, f"frame_{k}", dtype=dtype).to(device=device) for k in range(1, 7)
        ),
        mass=tensor(bodies.mass),
        center_of_mass=tensor(bodies.center_of_mass),
        inertia=tensor(bodies.inertia),
        gravity=tensor(robot.gravity),
    )


def read_urdf(text: str, dtype: torch.dtype) -> pk.Chain:
    """A kinematic chain from URDF, with the origins of its joints in full precision.

    pytorch-kinematics reads rotations in single precision, which misplaces the UR5's flange by
    16 nm; the exact origins are put back here. The chain is a template for `pk.SerialChain`.
    """
    chain = pk.build_chain_from_urdf(text.encode())
    for name in chain.get_frame_names(exclude_fixed=False):
        chain.find_frame(name).link.offset = None  # places the link's drawing, in single precision
    for joint in ElementTree.fromstring(text).iter("joint"):
        child, origin = (joint.findall(name)[0].attrib for name in ("child", "origin"))
        frame = chain.find_frame(child["link"])
        frame.joint.offset = _transform(origin["xyz"], origin["rpy"], dtype)
    return chain


def _transform(xyz: str, rpy: str, dtype: torch.dtype) -> pk.Transform3d:
    position, angles = (
        torch.tensor([float(value) for value in text.split()], dtype=torch.float64)
        for text in (xyz, rpy)
    )
    # About fixed axes: R = R_z(yaw) R_y(pitch) R_x(roll).
    rotation = pk.euler_angles_to_matrix(angles.flip(0), "ZYX")
    return pk.Transform3d(rot=rotation.to(dtype), pos=position.to(dtype), dtype=dtype)

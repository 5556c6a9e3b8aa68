"""Kinematic chains of an arm, by pytorch-kinematics.

Importing it takes half as long as torch, because of its plotting packages, so it is imported only
for poses and Jacobians.
"""

from functools import cache
from xml.etree import ElementTree

import pytorch_kinematics as pk
import torch


@cache
def serial_chain(text: str, link: int, dtype: torch.dtype, device: torch.device) -> pk.SerialChain:
    """Return the chain from the base to frame k of a link, 1 to n, of an arm as URDF."""
    chain = pk.SerialChain(read_urdf(text, dtype), f"frame_{link}", dtype=dtype)
    return chain.to(device=device)


def read_urdf(text: str, dtype: torch.dtype) -> pk.Chain:
    """Read a kinematic chain from URDF, with the origins of its joints in full precision.

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

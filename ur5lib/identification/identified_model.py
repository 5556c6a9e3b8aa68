"""Identified parameters as one more model of an arm."""

import numpy as np

from ur5lib.robots.description import Model, Robot
from ur5lib.robots.inertia import link_tail, shift_inertia, tensor
from ur5lib.timeseries.arrays import Array


def identified_model(robot: Robot, parameters: Array, description: str) -> Model:
    """Return the model of an arm with inertial parameters π = parameters (P,).

    π as in `ur5lib.dynamics.arm.inertial_parameters`, in the URDF's frames link_k; a payload
    belongs to the last link. Raises ValueError if a mass or a rotor inertia is negative.
    """
    masses, centers, inertias = [], [], []
    poses = robot.link_poses()
    links, rotors = np.split(parameters, [10 * len(poses)])
    for link, pose in zip(links.reshape(-1, 10), poses, strict=True):
        mass, center = link[0], link[1:4] / link[0]
        rotation, translation = link_tail(pose)
        about_origin = tensor(link[[4, 6, 9, 5, 7, 8]].tolist())
        inertia = rotation.T @ shift_inertia(about_origin, -mass, center) @ rotation
        masses.append(float(mass))
        centers.append(tuple((rotation.T @ (center - translation)).tolist()))
        inertias.append(tuple(inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].tolist()))
    return Model.model_validate(
        {
            "description": description,
            "masses": tuple(masses),
            "centers_of_mass": tuple(centers),
            "inertias": tuple(inertias),
            "rotor_inertias": tuple(rotors.tolist()),
        }
    )

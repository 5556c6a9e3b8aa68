"""Arms that differ in masses and gravity, all at once: each as it is alone."""

import numpy as np
import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.dynamics.many_arms import ManyArms
from ur5lib.dynamics.rigid_body import inertia_matrix
from ur5lib.robots.description import Payload, load_robot, robot_path

RANDOM = np.random.default_rng(2)
STATES = RANDOM.uniform(-2, 2, (2, 30, 6))


def test_each_has_its_masses_rotors_and_gravity() -> None:
    upright = load_robot(robot_path("ur5e"))
    hung = upright.mounted([3.0, 1.0, 9.0]).carrying(Payload(mass=2.0))
    kinds = [(upright, "maker"), (hung, "maker+rotors"), (upright, "maker+rotors")]
    of, rotors = np.arange(30) % 3, RANDOM.uniform(0, 1, (30, 6))
    matrix, bias = ManyArms(kinds, of, rotors).equation_of_motion(*STATES)
    for k, (robot, model) in enumerate(kinds):
        q, qd = (own[of == k] for own in STATES)
        alone = LinkModel(robot, model).inverse_dynamics(q, qd, 0 * q)
        np.testing.assert_allclose(bias[of == k], alone, atol=1e-9)
        bare = inertia_matrix(build_arm(robot, model), torch.from_numpy(q)).numpy()
        added = rotors[of == k][:, None] * np.eye(6)
        np.testing.assert_allclose(matrix[of == k], bare + added, atol=1e-9)

"""Chunk by chunk is the whole, and takes no more memory on the way."""

import numpy as np
import pytest

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import flange_kinematics
from ur5lib.timeseries import segments as module
from ur5lib.timeseries.segments import chunks, in_chunks


@pytest.mark.parametrize("count", [0, 1, 5, 6, 17])
def test_chunks_cover_all_samples_once(count: int) -> None:
    values = np.arange(count)
    parts = [values[rows] for rows in chunks(count, 6)]
    np.testing.assert_array_equal(np.concatenate([[], *parts]), values)
    assert all(0 < len(part) <= 6 for part in parts)


@pytest.mark.parametrize("count", [0, 3, 40_000])
def test_in_chunks_is_the_function_of_the_whole(count: int) -> None:
    x, y = np.random.default_rng(0).normal(size=(2, count, 6))
    sizes = []

    def outer(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        sizes.append(len(x))
        return x[:, :, None] * y[:, None]

    np.testing.assert_array_equal(in_chunks(outer, x, y), x[:, :, None] * y[:, None])
    assert max(sizes) <= module.CHUNK_SAMPLES


def test_dynamics_do_not_depend_on_chunks(ur5: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    q, qd = np.random.default_rng(1).uniform(-2, 2, (2, 50, 6))
    model = LinkModel(ur5, "C")

    def everything() -> list[np.ndarray]:
        return [*flange_kinematics(ur5, q), model.momentum(q, qd), model.coriolis_torque(q, qd)]

    whole = everything()
    monkeypatch.setattr(chunks, "__defaults__", (16,))
    for part, expected in zip(everything(), whole, strict=True):
        np.testing.assert_allclose(part, expected, rtol=1e-13, atol=1e-13)

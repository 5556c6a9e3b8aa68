"""Pushes at flange, tool and elbow of a simulated arm, drawn by a seed."""

from typing import Any

import numpy as np

EACH = 3  # contacts at each place
PLACES = {"flange": (6, (0, 0, 0)), "tool": (6, (0, 0, 0.15)), "elbow": (2, (0, 0, 0))}
FORCES = 5.0, 80.0  # N, their range
PAUSE, LASTS = 4.0, 2.0  # s


def pushes(seed: int, each: int) -> list[dict[str, Any]]:
    """Return contacts at all places in random order, one every PAUSE."""
    random = np.random.default_rng(seed)
    places = [PLACES[place] for place in random.permutation([*PLACES] * each)]
    return [push(k, link, point, random) for k, (link, point) in enumerate(places)]


def push(k: int, link: int, point: Any, random: np.random.Generator) -> dict[str, Any]:
    """Return the k-th push, at a point of a link [m], of random size and direction."""
    way = random.normal(size=3)
    force = random.uniform(*FORCES) * way / np.linalg.norm(way)
    where = {"link": link, "point": point, "start_s": 2 + PAUSE * k, "seconds": LASTS}
    return {"kind": "push", "force": force.tolist(), **where}

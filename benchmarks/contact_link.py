"""Which link of a simulated arm was touched: by the torques of contacts anywhere along every link.

For each seed, three recordings to fit are simulated and one that is pushed twice on each link and a
tool 20 cm long, at a random place along it and beside its middle line, with 5 to 80 N in random
directions. When a contact is, the plan says; where, the currents. Counted are contacts whose link
is named right, wrong, or not at all, because their torques cannot tell, and those that are on one
of the links that are stated as likely. Writes results/contact_link.csv, from which
`make leaderboard` takes its table.
"""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from benchmarks.harness.options import asked
from benchmarks.harness.pushes import FORCES, LASTS, PAUSE, push
from benchmarks.harness.sections import link_table
from benchmarks.stand_seeds import Taken, currents, fitted_map, plans, residuals_of, taken
from ur5lib.dynamics.flange import link_frames
from ur5lib.force.contact_link import TOOL, likely_links, touched_link
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.pipeline.force_input import force_input
from ur5lib.pipeline.touched_links import middle_half, probabilities
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.tables import write_csv

SEEDS, EACH = 10, 2  # contacts on each link
SECONDS, QUICK_SECONDS = 20.0, 5.0  # of each recording to fit
TABLE = Path("results/contact_link.csv")
BESIDE = 0.06  # m, largest distance of a place from the middle line of its link
PRIOR = ContactPrior()


def main() -> None:
    """Write and print how many contacts are named right, wrong, and not at all."""
    seeds, quick = asked(__doc__, SEEDS)
    size = (1, QUICK_SECONDS) if quick else (EACH, SECONDS)
    torch.set_num_threads(1)
    rows: list[dict[str, Any]] = []
    for seed in range(seeds):
        rows += located(seed, *size)
        if not quick:
            write_csv(pd.DataFrame(rows), TABLE)
    print(f"{seeds} seeds, {len(rows)} contacts of {FORCES[0]:g} to {FORCES[1]:g} N")
    print(link_table(pd.DataFrame(rows)))


def pushes_anywhere(robot: Robot, seed: int, each: int) -> list[dict[str, Any]]:
    """Return contacts on all links in random order, one every PAUSE."""
    random = np.random.default_rng([seed, 2])
    links = random.permutation([*range(1, 7)] * each).tolist()
    return [push(k, link, _point(robot, link, random), random) for k, link in enumerate(links)]


def _point(robot: Robot, link: int, random: np.random.Generator) -> list[float]:
    """Return a random place on a link, in its frame [m]; link 6 ends with a tool."""
    rotation, origin = (part[0] for part in link_frames(robot, np.zeros((1, 6))))
    end = np.array([0, 0, TOOL])
    if link < 6:  # from its own frame back to the one before
        end = rotation[link].T @ (origin[link - 1] - origin[link])
    aside = random.normal(size=3)
    aside *= random.uniform(0, BESIDE) / np.linalg.norm(aside)
    point: list[float] = (random.uniform() * end + aside).tolist()
    return point


def located(seed: int, each: int, seconds: float) -> Iterator[dict[str, Any]]:
    """Yield the contacts of a seed with what the torques say of their link."""
    contacts = pushes_anywhere(load_robot(robot_path("ur5")), seed, each)
    *free, last = plans(seed, seconds)
    touched = last | {"contacts": contacts, "seconds": 2 + PAUSE * len(contacts)}
    with tempfile.TemporaryDirectory() as folder:
        *fitted, pushed = (
            taken(plan, Path(folder, str(k))) for k, plan in enumerate([*free, touched])
        )
    found = links_of(fitted, pushed, [contact["start_s"] for contact in contacts])
    for contact, links in zip(contacts, found, strict=True):
        best, likely = max(links, key=links.__getitem__), likely_links(links)
        yield {
            "seed": seed,
            "link": contact["link"],
            "force": np.linalg.norm(contact["force"]),
            "stated": links[best],
            "right": best == contact["link"],
            "named": touched_link(links) is not None,
            "likely": len(likely),
            "held": contact["link"] in likely,
        }


def links_of(fitted: list[Taken], pushed: Taken, starts: list[float]) -> Iterator[dict[int, float]]:
    """Yield the probability of each link at the contacts that start at some times [s]."""
    friction = fitted_map(fitted)
    model = residuals_of(friction, fitted).tau_ext
    own = currents(friction, pushed)
    assert model is not None
    assert own.external_torque is not None
    run, time = force_input(pushed.motion, own.external_torque, own), pushed.signals.time
    for start in starts:
        rows = middle_half(run, time, start, start + LASTS)
        yield probabilities(pushed.robot, run, model, PRIOR, rows)


if __name__ == "__main__":
    main()

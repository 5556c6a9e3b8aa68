"""Which link of a simulated arm was touched: by the torques of contacts at flange, tool and elbow.

For each seed, three recordings to fit are simulated and one that is pushed in turn at the flange,
15 cm beyond it and at the elbow, with 5 to 80 N in random directions. When a contact is, the plan
says; where, the currents. Counted are contacts whose link is named right, wrong, or not at all,
because their torques cannot tell; beside it stands the probability of the likelier link, and how
often it is the right one. Seeds 0 to 9 were in sight when the method was chosen; a run begins at
seed 10. Writes results/contact_link.csv, from which `make leaderboard` takes its table.
"""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from benchmarks.harness.links import link_table
from benchmarks.harness.options import asked
from benchmarks.stand_seeds import CURRENTS, Taken, currents, fitted_map, plans, taken
from ur5lib.dynamics import kinematics
from ur5lib.dynamics.arm import build_arm
from ur5lib.force.contact_link import link_probabilities, place_probabilities, touched_link
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.gate import Noise
from ur5lib.force.residual_model import ResidualModel
from ur5lib.identification.currents import CurrentFit, breakaway_torque
from ur5lib.pipeline.force_input import force_input
from ur5lib.pipeline.residual_fit import residual_summary
from ur5lib.tables import write_csv
from ur5lib.timeseries.arrays import Array

SEEDS, EACH = 20, 3  # contacts at each place
SEEN = 10  # first seeds, which were looked at
TABLE = Path("results/contact_link.csv")
PLACES = {"flange": (6, (0, 0, 0)), "tool": (6, (0, 0, 0.15)), "elbow": (2, (0, 0, 0))}
LINKS = {place: link for place, (link, _) in PLACES.items()}
FORCES = 5.0, 80.0  # N, their range
PAUSE, LASTS = 4.0, 2.0  # s
PRIOR = ContactPrior()
SIZES = [*PRIOR.sizes]  # N


def main() -> None:
    """Write and print how many contacts are named right, wrong, and not at all."""
    seeds, quick = asked(__doc__, SEEDS, SEEN)
    each = 1 if quick else EACH
    torch.set_num_threads(1)
    rows: list[dict[str, Any]] = []
    for seed in range(SEEN, SEEN + seeds):
        rows += named(seed, each)
        if not quick:
            write_csv(pd.DataFrame(rows), TABLE)
    print(f"{seeds} seeds, {len(rows)} contacts of {FORCES[0]:g} to {FORCES[1]:g} N")
    print(link_table(pd.DataFrame(rows)))


def pushes(seed: int, each: int) -> list[dict[str, Any]]:
    """Return contacts at all places in random order, one every PAUSE."""
    random = np.random.default_rng(seed)
    found = []
    for k, place in enumerate(random.permutation([*PLACES] * each)):
        way = random.normal(size=3)
        force = random.uniform(*FORCES) * way / np.linalg.norm(way)
        link, point = PLACES[place]
        where = {"link": link, "point": point, "start_s": 2 + PAUSE * k, "seconds": LASTS}
        found.append({"kind": "push", "force": force.tolist(), **where})
    return found


def named(seed: int, each: int) -> Iterator[dict[str, Any]]:
    """Yield the contacts of a seed with what the torques say of their place."""
    contacts = pushes(seed, each)
    *free, last = plans(seed, 20.0)
    touched = last | {"contacts": contacts, "seconds": 2 + PAUSE * len(contacts)}
    with tempfile.TemporaryDirectory() as folder:
        *fitted, pushed = (
            taken(plan, Path(folder, str(k))) for k, plan in enumerate([*free, touched])
        )
    places = [place for contact in contacts for place in PLACES if _at(contact) == PLACES[place]]
    found = contact_links(fitted, pushed, contacts)
    for contact, place, links in zip(contacts, places, found, strict=True):
        link, best = touched_link(links), max(links, key=links.__getitem__)
        yield {
            "seed": seed,
            "place": place,
            "force": np.linalg.norm(contact["force"]),
            "stated": links[best],
            "right": best == LINKS[place],
            "named": link is not None,
        }


def _at(contact: dict[str, Any]) -> tuple[int, Any]:
    return contact["link"], contact["point"]


def contact_links(
    fitted: list[Taken], pushed: Taken, contacts: list[dict[str, Any]]
) -> Iterator[dict[int, float]]:
    """Yield the probability of each link at a contact, from the torques of its middle half."""
    friction = fitted_map(fitted)
    model = residual_model(friction, fitted)
    own = currents(friction, pushed)
    assert own.external_torque is not None
    run = force_input(pushed.motion, own.external_torque, own)
    noise = Noise.of(run.states, model, PRIOR, np.zeros_like(run.torque))
    levers = {place: lever(pushed, place) for place in PLACES}
    for contact in contacts:
        since = (pushed.signals.time - contact["start_s"]) / contact["seconds"]
        rows = (since > 0.25) & (since < 0.75) & finite_rows(run.torque)
        spread = (noise.spread + noise.hidden)[rows] * np.eye(6)
        here = {place: values[rows] for place, values in levers.items()}
        yield link_probabilities(place_probabilities(run.torque[rows], here, spread, SIZES), LINKS)


def residual_model(friction: dict[str, Any], free: list[Taken]) -> ResidualModel:
    """Return what is left of the torque without contact."""
    breakaway = breakaway_torque(CurrentFit.from_plain(friction["fit"]))
    known = [(currents(friction, own), own.motion) for own in free]
    settings = friction["paths"], CURRENTS.cutoff, friction["explained"]
    return ResidualModel.from_dict(residual_summary(known, breakaway, *settings)["tau_ext"])


def lever(own: Taken, place: str) -> Array:
    """Return J_v (N, 3, 6) of a place of the arm."""
    link, point = PLACES[place]
    arm, q = build_arm(own.robot, own.robot.chosen_model), torch.from_numpy(own.motion.q)
    at = torch.tensor(point, dtype=torch.float64)
    return np.asarray(kinematics.jacobian(arm, q, link, at)[:, :3].numpy())


if __name__ == "__main__":
    main()

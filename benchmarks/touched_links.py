"""Pushes before the flange of a moving arm on the virtual test stand: what is found of each.

    python -m benchmarks.touched_links [--seeds <n>] [--page] [--quick]

Each study is the usual one of `benchmarks/world.py`, pushed at elbow, forearm or wrist 1. A row for
each place: of its pushes above 20 N, how many are found after the recording and by the live
estimate, and for how many of these the touched link or one next to it is named, as one before the
last; in the middle of all pushes, and of found ones, share of the true force's components in the
95 % band; of all, the band's interval score beside that of plain least squares, with an even band
that holds 95 % of what is untouched; false alarms. `--page` writes the section of docs/world.md.
"""

import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.harness.markdown import markdown, read_page, replaced, write_page
from benchmarks.harness.options import options_of
from benchmarks.harness.situations import Situation, plans
from benchmarks.study import snakemake
from benchmarks.world import LINKS, MIN_SINGULAR_VALUE, PAGE, recorded
from ur5lib.force.estimators import LEADING
from ur5lib.force.plain_least_squares import plain_least_squares
from ur5lib.force.touched_link import LIKELY
from ur5lib.records.contacts import Contacts
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.tables import read_record
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import NORMAL95, interval_scores
from ur5lib.timeseries.segments import runs
from ur5lib.topics.live.rows import LiveForces

PLACES = {  # link, and the place in its frame [m]
    "elbow": (3, (0.0, 0.0, 0.0)),
    "forearm": (3, (0.196, 0.0, 0.0)),
    "wrist 1": (4, (0.0, 0.0, 0.0)),
}
RAW, RESULTS, SEEDS = Path("raw/links"), Path("results"), 6
FIRST_SEED = 1000  # of draws that are no row of the world
MIN_FORCE = 20.0  # N; of pushes that count as found or missed
MIDDLE = 0.3, 0.7  # of a push, where the low-pass hardly blurs it
AFTER = 0.3  # s after a push, in which an alarm is still its own
HEADS = ["place", "pushes above 20 N", "found", "link named", "inside", "inside, found ones"]
HEADS += [
    "score / plain's [N]",
    "found live",
    "link named live",
    "delay live, median [s]",
    "false",
    "false live",
]


def main() -> None:
    """Print a row for each place, or write them to the page."""
    options = options_of(__doc__)
    options.add_argument("--page", action="store_true", help="write docs/world.md as well")
    options.add_argument("--seeds", type=int, default=SEEDS, help="how many of each place")
    given = options.parse_args()
    names = [*PLACES][: 1 if given.quick else None]
    jobs = product(names, range(1 if given.quick else given.seeds))
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        rows = [row for found in pool.map(judged, *zip(*jobs, strict=True)) for row in found]
    found = markdown(HEADS, [*lines(pd.DataFrame(rows))])
    print(found)
    if given.page:
        write_page(replaced(read_page(PAGE), LINKS, found), PAGE)


def judged(place: str, seed: int) -> list[dict[str, Any]]:
    """Return a row for each push on a place in the study of a seed, and one for its alarms."""
    link, point = PLACES[place]
    own, number = Situation(link=link, point=point), [*PLACES].index(place)
    study = f"links-{number + 1}-{seed}"
    entries = [*recorded(own, FIRST_SEED + seed, number, RAW / study)]
    tables = [f"{RESULTS / study}/tables/{name}.csv" for name in ("contacts", "live_detection")]
    plan = {"study": study, "title": f"{place}, seed {seed}", "recordings": entries}
    snakemake(plan, "--cores", "1", "--", *tables)
    drawn = plans(own, [FIRST_SEED + seed, number], load_robot(robot_path(own.arm)))
    [pushes] = [plan["contacts"] for name, _, plan in drawn if name == "moving"]
    about = {"place": place, "seed": seed}
    at = RESULTS / study / "recordings" / "moving"
    return [about | row for row in rows_of(at, pushes, link)]


def rows_of(at: Path, pushes: list[dict[str, Any]], link: int) -> Iterator[dict[str, Any]]:
    """Yield a row for each push of a recording, and one with its false alarms."""
    forces, live = Forces.read(at / "forces.parquet"), LiveForces.read(at / "live_forces.parquet")
    time = forces.time - forces.time[0]
    spans = [(push["start_s"], push["start_s"] + push["seconds"]) for push in pushes]
    free = ~np.any([(time > a - AFTER) & (time < b + AFTER) for a, b in spans], axis=0)
    alarms = [
        (one.start_s - forces.time[0], one.end_s - forces.time[0], one.off_flange, one.link or 0)
        for one in read_record(Contacts, str(at / "contacts.json")).contacts
        if one.estimate == LEADING
    ]
    stated = [*live_alarms(live)]
    for push, span in zip(pushes, spans, strict=True):
        known = {"size": float(np.linalg.norm(push["force"]))}
        for name, of in ("", alarms), (" live", stated):
            own = [one for one in of if one[0] < span[1] and one[1] > span[0]]
            known |= {f"found{name}": bool(own)}
            known |= {f"named{name}": any(one[2] and abs(one[3] - link) <= 1 for one in own)}
            known |= {f"delay{name}": max(own[0][0] - span[0], 0.0) if own else np.nan}
        first, last = (span[0] + share * push["seconds"] for share in MIDDLE)
        yield known | scores(
            at, forces, np.array(push["force"]), (time > first) & (time < last), free
        )
    for name, of in ("", alarms), (" live", stated):
        extra = sum(all(one[1] < a or one[0] > b + AFTER for a, b in spans) for one in of)
        yield {f"false{name}": extra, "minutes": time[-1] / 60}


def live_alarms(live: LiveForces) -> Iterator[tuple[float, float, bool, int]]:
    """Yield start and end [s] of each contact of the live estimate, and its link at its end, with
    whether that is one before the last; nothing where it is refused, as for a term of friction
    that it lacks.
    """
    if live.contact is None:
        return
    assert live.link is not None
    assert live.off_flange is not None
    time = live.time - live.time[0]
    for first, last in runs(live.contact).tolist():
        link, off_flange = np.nan_to_num([live.link[last - 1], live.off_flange[last - 1]])
        yield time[first], time[last - 1], bool(off_flange >= LIKELY), int(link)


def scores(at: Path, forces: Forces, true: Array, inside: Mask, free: Mask) -> dict[str, float]:
    """Return share in the band and interval scores where `inside`, of F̂ᵐᵃᵖ and plain's; free: (N,),
    untouched samples, of which plain's even band holds 95 %.
    """
    external = Currents.read(at / "currents.parquet").external_torque
    assert external is not None
    jacobian = Kinematics.read(at / "kinematics.parquet").jacobian
    plain = plain_least_squares(external, jacobian, MIN_SINGULAR_VALUE)[:, :3]
    even = np.nanquantile(np.abs(plain)[free], 0.95, axis=0) / NORMAL95
    wrench, std = forces.wrench["Fmap"][inside, :3], forces.std["Fmap"][inside, :3]
    return {
        "inside": float((np.abs(wrench - true) <= NORMAL95 * std).mean()),
        "score": float(interval_scores(wrench, std, true).mean()),
        "plain": float(interval_scores(plain[inside], even, true).mean()),
    }


def lines(rows: pd.DataFrame) -> Iterator[list[str]]:
    """Yield the cells of each place."""
    for place, own in rows.groupby("place", sort=False):
        pushes = own.dropna(subset=["size"])
        large = pushes[pushes["size"] > MIN_FORCE]
        cells = [str(place), f"{len(large)}"]
        for name in ("", " live"):
            found = large[large[f"found{name}"].astype(bool)]
            cells += [f"{len(found)}", f"{found[f'named{name}'].sum():.0f} of {len(found)}"]
            if not name:
                seen = pushes[pushes["found"].astype(bool)]
                cells += [f"{pushes['inside'].mean():.2f}", f"{seen['inside'].mean():.2f}"]
                cells += [f"{pushes['score'].mean():.0f} / {pushes['plain'].mean():.0f}"]
        cells += [f"{large['delay live'].median():.2f}"]
        minutes = own["minutes"].sum() / 2
        yield [
            *cells,
            *(f"{own[f'false{name}'].sum():.0f} in {minutes:.1f} min" for name in ("", " live")),
        ]


if __name__ == "__main__":
    main()

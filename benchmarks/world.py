"""A world of situations on the virtual test stand, each a study of its own: what F̂ᵐᵃᵖ errs in each.

    python -m benchmarks.world [<situation> ...] [--seeds <n>] [--page] [--quick]

A study has recordings to fit on, a free one, one that is pushed in motion and one at rest; what its
situation changes, `benchmarks/harness/situations.py` lists. Each draws its own paths and pushes;
friction and held torques vary from run to run. Recordings are simulated, written as files of RTDE
channels, and taken through the workflow up to the tables. In contact, by the truth: error of the
force beside that of plain least squares and of an estimate of zero, share inside the 95 % band, its
interval score (width and 40 times what lies outside), there and in all samples with a known force,
beside plain's, whose even band holds 95 % of what is untouched, and its width over that of the
narrowest one that would hold 95 %; contacts found, false alarms; known torque constants inside
their interval; stop signs; the state of the forces.
What is built stays in raw/world and results/world-*. `--page` writes docs/world.md.
"""

import os
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pandas as pd

from benchmarks import stand_and_arms
from benchmarks.harness.markdown import folded, markdown, read_page, section, write_page
from benchmarks.harness.options import options_of
from benchmarks.harness.situations import SITUATIONS, Situation, described, plans
from benchmarks.study import snakemake
from ur5lib.force.matching import compare
from ur5lib.force.plain_least_squares import plain_least_squares
from ur5lib.force.thresholds import alarms
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import STANDARD_GRAVITY
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.stand.truth import TrueParameters, Truth
from ur5lib.study.arms import base_gravity
from ur5lib.tables import read_csv, read_record
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.metrics import NORMAL95, interval_scores
from ur5lib.timeseries.segments import spans

RAW, RESULTS, SEEDS = Path("raw/world"), Path("results"), 3
MIN_SINGULAR_VALUE = 0.01  # of plain least squares, as the default of a study
TOUCHED = 0.1  # a sample above this share of a contact's largest torque is in contact
MIN_TORQUE = 1e-6  # Nm; of any contact
CURRENTS = 4, 2.0  # order and cut-off [Hz] of the torques' low-pass, as the default of a study
TABLES = ("verdicts", "torque_constants")
LATE = "actual_current_2"  # of the joint that is late
BORNE = 1.0  # Nm; at a larger torque, a joint lies against one side of its backlash
LINKS = "Contacts before the flange"  # the section by `benchmarks.touched_links`
PAGE = Path("docs/world.md")
HEAD = """# A world of situations

Each line is a study on the [virtual test stand](methods.md#virtual-test-stand), {seeds}: two
fits in motion and one with stops, a free recording, one that is pushed in motion and one at rest,
with one thing changed; each draws its own paths and pushes. Friction and the torques held at stops
vary from run to run. `python -m benchmarks.world --seeds <n> --page` writes this page;
`benchmarks/harness/situations.py` has the situations.

![Error of the force over that of plain least squares, and share inside the 95 % band, a situation a
row: nearly all are below one.](pictures/world.svg)

- Errors are root mean squares of the force vector in contact, by the truth, low-passed as torques
  are; plain: least squares of the external torques.
- Inside: share of components in the 95 % band; score: its width and 40 times what lies outside,
  mean of the axes, and plain's, whose even band holds 95 % of what is untouched; wide: its width
  over that which would hold 95 %.
- Found: contacts of all recordings; false: alarms without one; constants: determined ones whose
  interval contains the truth.
- At the elbow and the forearm, contacts count as found, and no error is stated: the next table
  has it.
- With joint torque sensors, plain least squares errs less, by less than a newton; the study's
  verdict on the force says so (`rival_better`).

"""
FILE, PLAN = "robot.csv", "plan.txt"
COLUMNS = ["situation", "ours [N]", "plain [N]", "zero [N]", "ours / plain", "inside"]
COLUMNS += [
    "score in contact / plain's / whole [N]",
    "wide, moving",
    "wide, resting",
    "found",
    "false",
    "constants",
    "stop signs",
    "state",
]


def main() -> None:
    """Print a line for each situation, or write its page."""
    options = options_of(__doc__)
    options.add_argument("situations", nargs="*", help="by default all")
    options.add_argument("--page", action="store_true", help="write docs/world.md as well")
    options.add_argument("--seeds", type=int, default=SEEDS, help="how many of each")
    given = options.parse_args()
    names = given.situations or [*SITUATIONS][: 1 if given.quick else None]
    jobs = [(name, seed) for name in names for seed in range(1 if given.quick else given.seeds)]
    arms = {arm for name in names for arm in SITUATIONS[name].arms}
    with described(arms), ProcessPoolExecutor(os.cpu_count()) as pool:
        rows = [row for found in pool.map(judged, *zip(*jobs, strict=True)) for row in found]
    found = table(pd.DataFrame(rows))
    print(found)
    if given.page:
        page = read_page(PAGE)
        beside = section(page, LINKS) + section(page, stand_and_arms.TITLE)
        head = HEAD.format(seeds=f"{given.seeds} seed{'s' * (given.seeds > 1)}")
        write_page(f"{head}{folded('world', found)}\n\n{beside}", PAGE)


def judged(name: str, seed: int) -> list[dict[str, Any]]:
    """Return the counts of a situation with a seed, by recording."""
    own, number = SITUATIONS[name], [*SITUATIONS].index(name)
    study = f"world-{number + 1:02}-{seed}"
    raw, built = RAW / study, RESULTS / study
    entries = [*recorded(own, seed, number, raw)]
    if own.beside:
        other = recorded(replace(own, arm=own.beside), seed, number, raw / own.beside)
        entries += [entry | {"name": f"{own.beside}-{entry['name']}"} for entry in other]
    plan = {"study": study, "title": name, "recordings": entries}
    targets = [f"{built}/tables/{table}.csv" for table in TABLES]
    snakemake(plan, "--cores", "1", "--", *targets)
    return [row | {"seed": seed} for row in counts(name, built, entries)]


def recorded(own: Situation, seed: int, number: int, folder: Path) -> Iterator[dict[str, Any]]:
    """Simulate and write the recordings of a situation; yield the study's entries for them."""
    arm = load_robot(robot_path(own.arm))
    gravity = None if own.mounting is None else base_gravity(own.mounting, STANDARD_GRAVITY)
    for k, (name, role, plan) in enumerate(plans(own, [seed, number], arm)):
        at = folder / name
        plan |= {"seed": 100 * seed + k, "varied_friction": True} | (
            {"wrist_sensor": {}} if role == "contact" else {}
        )
        wanted = f"{own}\n{plan}\n"
        if not (at / PLAN).exists() or (at / PLAN).read_text(encoding="utf-8") != wanted:
            with ExitStack() as changed:
                for place, other in own.constants.items():
                    changed.enter_context(patch(place, other))
                simulated = SimulatedRecording.model_validate(plan)
                simulate(arm.mounted(gravity), simulated, "rtde-csv", at, at / "truth")
            altered(own, at / FILE, np.random.default_rng([seed, k]))
            (at / PLAN).write_text(wanted, encoding="utf-8")
        entry: dict[str, Any] = {"name": name, "robot": own.arm, "role": role}
        entry |= {"format": "rtde-csv", "file": FILE, "folder": str(at), "truth": "truth"}
        entry |= {} if own.mounting is None else {"mounting": own.mounting}
        if own.declared is not None:
            entry["contact_place"] = {"position_m": [0.0, 0.0, own.declared]}
        if name == "resting" and own.untouched:
            entry["untouched"] = list(own.untouched)
        yield entry


def altered(own: Situation, file: Path, random: np.random.Generator) -> None:
    """Write a file of 500 Hz at the situation's rate, with what its drives add to positions,
    velocities and currents.
    """
    rows = pd.read_csv(file).iloc[:: 500 // own.rate]
    columns = [name for name in rows if name.startswith("actual_current")]
    current = rows[columns] + own.noise * random.normal(size=(len(rows), len(columns)))
    if own.step:
        current = own.step * (current / own.step).round()
    if own.late:
        current[LATE] = current[LATE].shift(round(own.late * own.rate)).bfill()
    rows = rows.assign(**current)
    if own.compliance or own.backlash:
        # q_measured = q + τ / k + b / 2 tanh(τ / τ₁): drives lead the links that they carry
        q, qd, torque = (
            rows.filter(regex=rf"^{name}_\d").to_numpy()
            for name in ("actual_q", "actual_qd", "target_moment")
        )
        ahead = own.compliance * torque + own.backlash / 2 * np.tanh(torque / BORNE)
        rows[[f"actual_q_{k}" for k in range(q.shape[1])]] = q + ahead
        rate = np.gradient(ahead, rows["timestamp"].to_numpy(), axis=0)
        rows[[f"actual_qd_{k}" for k in range(q.shape[1])]] = qd + rate
    rows.to_csv(file, index=False)


def counts(name: str, built: Path, entries: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield the counts of a built study: of each recording, and of the whole study."""
    verdicts, known = (read_csv(built / f"tables/{table}.csv") for table in TABLES[:2])
    force = verdicts[verdicts["question"] == "force"].iloc[:1]
    state, reason = (str(force[column].iloc[0]) for column in ("state", "reason"))
    rows = known[known["determined"] == "yes"]
    folders = {entry["robot"]: Path(entry["folder"]) for entry in entries}
    drives = {
        robot: read_record(TrueParameters, str(folder / "truth.json")).drive.torque_constant
        for robot, folder in folders.items()
    }
    true = [drives[row.robot][int(row.joint) - 1] for row in rows.itertuples()]
    signs = verdicts.loc[verdicts["quantity"] == "stop signs", "count"].sum()
    about = {"situation": name, "state": state, "reason": reason, "signs": int(signs)}
    about |= {
        "constants": len(rows),
        "true": int(((rows["low"] <= true) & (true <= rows["high"])).sum()),
    }
    for entry in entries:
        if entry["role"] == "fit":
            continue
        at = built / "recordings" / entry["name"]
        place = str(built / f"parameters/{entry['robot']}/threshold.json")
        forces = Forces.read(at / "forces.parquet")
        truth = Truth.read(Path(entry["folder"]) / "truth.parquet")
        found = errors(at, forces, truth, read_record(dict[str, float], place))
        yield about | {"recording": entry["name"]} | found


def errors(
    at: Path, forces: Forces, truth: Truth, thresholds: Mapping[str, float]
) -> dict[str, Any]:
    """Return sums over the samples in contact of a recording, and its contacts and alarms.

    The true force is low-passed like torques; where the elbow is touched, none is stated.
    """
    if "Fmap" not in forces.wrench:
        return {}
    known = truth.at(forces.time)
    wrench, torque = (np.nan_to_num(own) for own in (known.wrench, known.contact_torque))
    true = zero_phase_lowpass(wrench[:, :3], 1 / forces.period, *CURRENTS)
    size: Array = np.linalg.norm(torque, axis=1)
    touched: Mask = size > max(TOUCHED * size.max(), MIN_TORQUE)
    external = Currents.read(at / "currents.parquet").external_torque
    assert external is not None
    jacobian = Kinematics.read(at / "kinematics.parquet").jacobian
    plain = plain_least_squares(external, jacobian, MIN_SINGULAR_VALUE)[:, :3]
    error, band = (forces.wrench["Fmap"][:, :3] - true), NORMAL95 * forces.std["Fmap"][:, :3]
    used = (
        touched
        & (wrench != 0).any(axis=1)
        & np.isfinite(error).all(axis=1)
        & np.isfinite(plain).all(axis=1)
    )
    raised = alarms(forces.log_odds["Fmap"], thresholds.get("Fmap", 0.0))
    found = compare(raised, spans(touched.astype(float), 0.5, 0.5), forces.period)
    needed = np.abs(error[used]) / band[used]
    return {
        "samples": int(used.sum()),
        "ours": float((error[used] ** 2).sum()),
        "plain": float(((plain - true)[used] ** 2).sum()),
        "zero": float((true[used] ** 2).sum()),
        "inside": float((needed <= 1).mean(axis=1).sum()),
        "wide": 1 / float(np.quantile(needed, 0.95)) if used.any() else np.nan,
        "contacts": found.contacts,
        "found": found.found,
        "false": found.extra if touched.any() else len(raised),
        "minutes": len(size) * forces.period / 60,
    } | scores(forces, plain, true, used, ~touched)


def scores(forces: Forces, plain: Array, true: Array, used: Mask, free: Mask) -> dict[str, float]:
    """Return sums of interval scores, mean of the axes: where used, plain's there, and of all.

    plain, true: (N, 3) [N]; used: (N,) bool, in contact; free: (N,) bool, untouched. Plain's band
    is even, and holds 95 % of what is free.
    """
    own = interval_scores(forces.wrench["Fmap"][:, :3], forces.std["Fmap"][:, :3], true)
    known = np.where(used | free, own.mean(axis=1), np.nan)
    even = np.nanquantile(np.abs(plain - true)[free], 0.95, axis=0) / NORMAL95
    return {
        "score": float(known[used].sum()),
        "plain_score": float(interval_scores(plain, even, true)[used].mean(axis=1).sum()),
        "whole": float(np.nansum(known)),
        "known": int(np.isfinite(known).sum()),
    }


def told(value: float, digits: int) -> str:
    """Return a number, – where there is none."""
    return f"{value:.{digits}f}" if np.isfinite(value) else "–"


def table(rows: pd.DataFrame) -> str:
    """Return a line for each situation."""
    lines = []
    for name, own in rows.groupby("situation", sort=False):
        sums, once = own.sum(numeric_only=True), own.drop_duplicates("seed")  # a study each
        count, known = (sums[name] or np.nan for name in ("samples", "known"))
        ours, plain, zero = (np.sqrt(sums[kind] / count) for kind in ("ours", "plain", "zero"))
        wide = own.groupby("recording")["wide"].mean()
        lines.append(
            [
                str(name),
                *(told(value, 1) for value in (ours, plain, zero)),
                told(ours / plain, 2),
                told(sums["inside"] / count, 2),
                " / ".join(
                    told(value, 0)
                    for value in (
                        sums["score"] / count,
                        sums["plain_score"] / count,
                        sums["whole"] / known,
                    )
                ),
                *(told(wide.get(kind, np.nan), 1) for kind in ("moving", "resting")),
                f"{sums['found']:.0f} of {sums['contacts']:.0f}",
                f"{own['false'].sum():.0f} in {own['minutes'].sum():.1f} min",
                f"{once['true'].sum()} of {once['constants'].sum()}",
                f"{own['signs'].max()}",
                ", ".join(sorted({*(own["state"] + " " + own["reason"])})),
            ]
        )
    return markdown(COLUMNS, lines)


if __name__ == "__main__":
    main()

"""Studies of simulated arms, drawn by a seed: three recordings to fit on, and a pushed one."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.harness.pushes import PAUSE
from ur5lib.stand.plan import POSTURE

ARMS = ("ur5", "ur5e", "ur10e")
FIT_SECONDS = 20.0
LIMIT_SHARES = (0.5, 0.1)  # of the limits of speed, in the excitations to fit on
PAUSE_S = 1.0  # s at each way-point of the third recording to fit on
FRICTION = (0.7, 1.3)  # range of each joint's friction, relative to the usual one
SWAY = 0.4  # rad, by which postures differ


def planned(
    seed: int, contacts: list[dict[str, Any]], seconds: float = FIT_SECONDS
) -> dict[str, Any]:
    """Return the study of a seed: three recordings to fit on, and the pushed one."""
    random = np.random.default_rng([seed, 1])
    friction = {
        name: random.uniform(*FRICTION, 6).tolist() for name in ("coulomb_factor", "viscous_factor")
    }
    moves = [fourier(random, share, seconds) for share in LIMIT_SHARES]
    moves.append(way_points(random, PAUSE_S))
    plans: list[dict[str, Any]] = [{"trajectory": own, "seconds": seconds} for own in moves]
    length = contacts[-1]["start_s"] + PAUSE
    plans.append({"trajectory": motion_of(seed), "seconds": length, "contacts": contacts})
    entries = [
        {
            "name": f"path_{k + 1}",
            "robot": ARMS[seed % len(ARMS)],
            "format": "thesis-csv",
            "role": "contact" if "contacts" in plan else "fit",
            "simulate": plan | friction | {"seed": len(plans) * seed + k},
        }
        for k, plan in enumerate(plans)
    ]
    return {"study": f"simulated-{seed}", "title": f"Seed {seed}", "recordings": entries}


def fourier(
    random: np.random.Generator,
    share: float,
    seconds: float = FIT_SECONDS,
    about: Sequence[float] = POSTURE,
) -> dict[str, Any]:
    """Return a drawn excitation about a drawn posture; share: used share of the limits; about: as
    of `posture`.
    """
    return {
        "kind": "fourier",
        "draw": int(random.integers(10**6)),
        "posture": posture(random, about),
        "period_s": seconds,
        "harmonics": 10,
        "limit_share": share,
    }


def motion_of(seed: int) -> dict[str, Any]:
    """Return the motion of the pushed recording: excitation, way-points or standstill."""
    random = np.random.default_rng([seed, 2])
    moves = [
        fourier(random, LIMIT_SHARES[0]),
        way_points(random, 0.0),
        {"kind": "standstill", "posture": posture(random)},
    ]
    return moves[int(random.integers(len(moves)))]


def way_points(
    random: np.random.Generator, pause: float, about: Sequence[float] = POSTURE
) -> dict[str, Any]:
    """Return a motion along drawn way-points with pauses [s]; about: as of `posture`."""
    drawn = [posture(random, about) for _ in range(4)]
    return {"kind": "movej", "way_points": drawn, "pause_s": pause}


def posture(random: np.random.Generator, about: Sequence[float] = POSTURE) -> list[float]:
    """Return a drawn posture [rad], far from singularities, as the one that it is drawn about."""
    drawn: list[float] = (about + random.uniform(-SWAY, SWAY, len(about))).tolist()
    return drawn

"""A made-up industrial arm of six joints, as its user knows it, and logs of its motors.

The truth is computed by Pinocchio: links similar to an ABB IRB 1600, rotors, and gears. Their dry
friction reverses gradually and varies along a turn; viscous, load-dependent and thinning friction
are added. The controller counts turns of the motors from its own home, two axes are reversed, and
motor 6 also turns with joint 5.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
import pandas as pd
import pinocchio
from scipy.interpolate import make_interp_spline

from ur5lib.identification.current_regression import UNSEEN_ERRORS
from ur5lib.timeseries.arrays import Array

JOINTS, WEIGHT = 6, 250.0  # 1, kg with the base, which torques do not depend on
# of each joint: position on the previous link [m], axis, range [deg], largest speed [deg/s]
CHAIN = (
    ((0, 0, 0.4865), (0, 0, 1), (-180, 180), 150),
    ((0.15, 0, 0), (0, 1, 0), (-90, 150), 160),
    ((0, 0, 0.7), (0, 1, 0), (-235, 55), 170),
    ((0.314, 0, 0), (1, 0, 0), (-200, 200), 320),
    ((0.294, 0, 0), (0, 1, 0), (-115, 115), 400),
    ((0.065, 0, 0), (1, 0, 0), (-400, 400), 460),
)
MASSES = (70.0, 45.0, 40.0, 15.0, 6.0, 2.0)  # kg, of the links
ROTORS = (12.0, 15.0, 8.0, 1.5, 1.0, 0.5)  # kg m²; on the joints' side of the gears, as all below
COULOMB = (60.0, 80.0, 40.0, 15.0, 10.0, 6.0)  # Nm
VISCOUS = (60.0, 80.0, 40.0, 8.0, 6.0, 4.0)  # Nm s/rad
THINNING = (10.0, 12.0, 6.0, 0.8, 0.6, 0.4)  # Nm s²/rad²
SPREAD = 0.3  # relative difference of arms from these values
LOST = 0.03, 0.05  # range of friction over transmitted torque
REVERSAL = 3e-4  # rad; dry friction reverses over it
# Relative RMS variation of dry friction along a turn, as on real arms along paths that no fit has
# seen.
UNEVEN, WAVES = UNSEEN_ERRORS[0], 3
OFFSET, NOISE, RIPPLE = 0.005, 0.02, 0.005  # of the largest torque
RESOLVER = 1e-3  # rad, noise of a motor's angle
STEP, EVERY = 1e-3, 4  # s, 1; of the simulation, which logs every fourth step
PERIOD, HARMONICS, BLEND = 12.0, 5, 2.0  # s, 1, s; of Fourier series, and between two of them
SPEED, RANGE = 0.5, 0.3  # shares of the limits of speed and range that the series use


class Counts(NamedTuple):
    """How the controller counts: gears N, directions d, home [rad], motor 6 per turn of joint 5."""

    gears: Array
    directions: Array
    home: Array
    ratio: float

    def coupling(self) -> Array:
        """Return C (6, 6) of the shafts."""
        matrix = np.eye(JOINTS)
        matrix[5, 4] = self.ratio
        return matrix


class MadeUpArm:
    """An arm, drawn from a seed."""

    def __init__(self, seed: int) -> None:
        """Draw links, gears, friction and the controller's counts."""
        random = np.random.default_rng(seed)
        names = ("ROTORS", "COULOMB", "VISCOUS", "THINNING")
        self.rotors, self.coulomb, self.viscous, self.thinning = (
            np.array(globals()[name]) * (1 + SPREAD * random.uniform(-1, 1, JOINTS))
            for name in names
        )
        self.lost, self.offset = random.uniform(*LOST, JOINTS), OFFSET * random.normal(size=JOINTS)
        self.phase = random.uniform(0, 2 * np.pi, (WAVES, JOINTS))
        directions = np.ones(JOINTS)
        directions[random.choice(JOINTS, 2, replace=False)] = -1
        self.counts = Counts(
            random.uniform(70, 130, JOINTS).round(2),
            directions,
            np.radians(random.uniform(-90, 90, JOINTS).round()),
            round(float(random.choice([-1, 1]) * random.uniform(0.5, 1.2)), 3),
        )
        self.file = tostring(arm_file(random, known=True))
        self.model = pinocchio.buildModelFromXML(self.file.decode())

    def motor_log(self, seed: int, motions: int, differs: float) -> pd.DataFrame:
        """Return time [s], angles [rad] and torques [Nm] of the motors in a run.

        differs: relative standard deviation of each joint's friction from run to run.
        """
        random = np.random.default_rng(seed)
        q, qd, qdd = drawn_motion(random, motions)
        data, counts = self.model.createData(), self.counts
        states = zip(q, qd, qdd, strict=True)
        torque = np.array([pinocchio.rnea(self.model, data, *state) for state in states])
        coupling = counts.coupling()
        shaft = (counts.directions * (q - counts.home)) @ coupling.T
        rate, change = ((counts.directions * v) @ coupling.T for v in (qd, qdd))
        # shafts and joints do the same work
        carried = (counts.directions * torque) @ np.linalg.inv(coupling)
        this_run = 1 + differs * random.normal(size=JOINTS)
        driven = carried + self.rotors * change + this_run * self.friction(shaft, rate, carried)
        largest = np.abs(driven).max(axis=0)
        noise = NOISE * random.normal(size=driven.shape) + RIPPLE * np.sin(3 * counts.gears * shaft)
        driven += largest * (noise + self.offset)
        angle = counts.gears * shaft + RESOLVER * random.normal(size=shaft.shape)
        table = pd.DataFrame({"time": STEP * np.arange(len(q))})
        table[[f"motor_angle_{k}" for k in range(1, JOINTS + 1)]] = angle
        table[[f"motor_torque_{k}" for k in range(1, JOINTS + 1)]] = driven / counts.gears
        return table[::EVERY]

    def friction(self, shaft: Array, rate: Array, carried: Array) -> Array:
        """Return the usual friction (N, 6) [Nm] of shafts that carry a torque."""
        direction, along = np.zeros_like(shaft), np.zeros(JOINTS)
        for k, step in enumerate(np.diff(shaft, axis=0), start=1):
            along += (np.sign(step) - along) * -np.expm1(-np.abs(step) / REVERSAL)
            direction[k] = along
        order = np.arange(1, WAVES + 1)[:, None, None]
        waves = np.cos(order * shaft + self.phase[:, None]).sum(axis=0)
        uneven = 1 + UNEVEN * np.sqrt(2 / WAVES) * waves
        dry = (self.coulomb * uneven + self.lost * np.abs(carried)) * direction
        wet = self.viscous * rate - self.thinning * rate * np.abs(rate)
        return np.asarray(dry + wet)

    def as_described(self, description: dict[str, Any]) -> dict[str, Any]:
        """Return a description by `ur5 describe`, completed with the user's knowledge of the
        controller.
        """
        counts, motors = self.counts, description["motors"]
        for name, gear in zip(description["joints"], counts.gears.tolist(), strict=True):
            motors[name]["gear_ratio"] = gear
        drives = {
            "positions": "motor",
            "directions": counts.directions.astype(int).tolist(),
            "home_deg": np.degrees(counts.home).round().tolist(),
            "coupling": [{"motor": 6, "joint": 5, "ratio": counts.ratio}],
        }
        return description | {"weight": WEIGHT, "effort": "motor_torque", "drives": drives}


def arm_file(random: np.random.Generator, known: bool) -> Element:
    """Return an arm's URDF, with drawn links (known) or, as its user has it, with placeholders.

    For half of the seeds, the placeholders weigh 1 kg each; for the others, there are none.
    """
    root = Element("robot", name="made-up")
    SubElement(root, "link", name="base")
    weighed = known or random.random() < 0.5
    tails = [np.array(place) for place, *_ in CHAIN[1:]] + [np.array([0.1, 0, 0])]
    for k, (place, axis, (low, high), speed) in enumerate(CHAIN):
        link = SubElement(root, "link", name=f"link_{k + 1}")
        if weighed:
            mass = MASSES[k] * random.uniform(0.8, 1.2) if known else 1.0
            add_inertial(link, mass, tails[k], random)
        joint = SubElement(root, "joint", name=f"joint_{k + 1}", type="revolute")
        SubElement(joint, "origin", xyz=" ".join(map(str, place)))
        SubElement(joint, "parent", link=f"link_{k}" if k else "base")
        SubElement(joint, "child", link=f"link_{k + 1}")
        SubElement(joint, "axis", xyz=" ".join(map(str, axis)))
        limits = {
            "lower": np.radians(low),
            "upper": np.radians(high),
            "velocity": np.radians(speed),
        }
        SubElement(joint, "limit", {name: f"{v:.6f}" for name, v in limits.items()}, effort="0")
    return root


def add_inertial(link: Element, mass: float, tail: Array, random: np.random.Generator) -> None:
    """Give a link the inertia of mass points about its middle; tail: to the next joint (3,) [m]."""
    size = 0.08 + 0.3 * float(np.linalg.norm(tail))
    points = tail * random.uniform(0, 1, (8, 1)) + size * random.uniform(-0.5, 0.5, (8, 3))
    center = points.mean(axis=0)
    second = (points - center).T @ (points - center) * mass / len(points)
    inertia = np.trace(second) * np.eye(3) - second
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "origin", xyz=" ".join(map(repr, center.tolist())))
    SubElement(inertial, "mass", value=repr(mass))
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    entries = zip(names, inertia[np.triu_indices(3)].tolist(), strict=True)
    SubElement(inertial, "inertia", {name: repr(value) for name, value in entries})


def drawn_motion(random: np.random.Generator, motions: int) -> tuple[Array, Array, Array]:
    """Return q, q̇, q̈ (N, 6) of several Fourier series, each about another posture."""
    time = np.arange(0, motions * PERIOD, STEP)
    q = np.zeros((len(time), JOINTS))
    low, high = np.radians([limits for _, _, limits, _ in CHAIN]).T
    low, high = np.maximum(low, -np.pi), np.minimum(high, np.pi)
    speed = np.radians([each for *_, each in CHAIN])
    order = 2 * np.pi / PERIOD * np.arange(1, HARMONICS + 1)
    for k in range(motions):
        size = random.normal(size=(HARMONICS, JOINTS)) / np.arange(1, HARMONICS + 1)[:, None]
        phase = random.uniform(0, 2 * np.pi, (HARMONICS, JOINTS))
        angle = order[:, None, None] * time[:, None] + phase[:, None]
        series = (size[:, None] * np.sin(angle)).sum(axis=0)
        rates = (size[:, None] * order[:, None, None] * np.cos(angle)).sum(axis=0)
        fast, far = np.abs(rates).max(axis=0), np.abs(series).max(axis=0)
        series *= np.minimum(SPEED * speed / fast, RANGE * (high - low) / far)
        room = 1.1 * RANGE * (high - low)
        posture = np.clip(random.uniform(low, high), low + room, high - room)
        q += window(time, k, motions)[:, None] * (posture + series)
    knots = slice(None, None, 20)  # a spline, for smooth derivatives
    spline = make_interp_spline(time[knots], q[knots], k=5)
    return spline(time), spline(time, 1), spline(time, 2)


def window(time: Array, k: int, motions: int) -> Array:
    """Return 1 during series k, 0 during others, with smooth transitions (N,)."""

    def risen(at: float) -> Array:
        share = np.clip((time - at) / BLEND + 0.5, 0, 1)
        return np.asarray(share**3 * (10 - 15 * share + 6 * share**2))

    start = risen(k * PERIOD) if k else np.ones_like(time)
    return start - (risen((k + 1) * PERIOD) if k < motions - 1 else 0.0)


def write_files(
    arm: MadeUpArm, seed: int, folder: Path, logs: Mapping[str, tuple[int, float]]
) -> None:
    """Write arm.urdf as its user has it, and logs; logs: by name, the number of motions, and the
    relative deviation of friction.
    """
    folder.mkdir(parents=True, exist_ok=True)
    placeholders = arm_file(np.random.default_rng([seed, 1]), known=False)
    (folder / "arm.urdf").write_bytes(tostring(placeholders))
    for k, (name, held) in enumerate(logs.items(), start=1):
        table = arm.motor_log(1000 * k + seed, *held)
        table.to_csv(folder / f"{name}.csv", index=False, float_format="%.8g")

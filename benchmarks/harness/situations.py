"""The situations of benchmarks/world.py, as differences from a usual study of the test stand."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import drawn_studies
from benchmarks.harness.drawn_studies import posture, way_points
from ur5lib.force.contact_prior import typical_force
from ur5lib.robots.description import PROJECT_FOLDER, Robot, robot_path
from ur5lib.stand.drive import CURRENT_RIPPLE
from ur5lib.stand.plan import POSTURE
from ur5lib.tables import write_text

FIT_SECONDS, PATHS = 12.0, 3
PAUSE = 1.0  # s, at each way-point
FORCES = 0.5, 4.0  # range of pushes, in typical forces
START, EVERY, LASTS = 2.0, 4.0, 2.0  # s, of pushes
MOVING, RESTING, HIDDEN = 4, 3, 2  # pushes in motion, at rest, and in a fit
HARMONICS, MAX_PERIOD = 8, 12.0  # s, of excitations

Plan = dict[str, Any]


@dataclass(frozen=True)
class Situation:
    """One situation.

    arm, mounting: of the study; tool: distance of the touched point from the flange [m]; declared:
    tool centre point of the study [m], None for none; paths: number of fit paths, of `seconds`
    each; stops: number of these with pauses; hidden: number of these that are pushed, and are not
    told so; rate: of the files [Hz]; forces: range of pushes [in typical forces]; lasts: their
    duration [s]; link, point: the touched place, in its frame [m], None for the tool; twice: two
    pushes at once; press: duration of a slow press at rest in place of pushes [s]; untouched: span
    of its recording [s]; later: further keys of recordings that are not fitted; plan: keys of all
    recordings; constants: of the stand, by name; noise: added to currents [A]; step: quantisation
    of currents [A]; late: time by which a joint's current is [s]; compliance [rad/Nm], backlash
    [rad]: between positions as measured and the links; beside: a second arm of the study; about:
    posture that postures are drawn about [rad].
    """

    arm: str = "ur5e"
    mounting: str | None = None
    tool: float = 0.08
    declared: float | None = 0.08
    paths: int = PATHS
    seconds: float = FIT_SECONDS
    stops: int = 2
    hidden: int = 0
    rate: int = 125
    forces: tuple[float, float] = FORCES
    lasts: float = LASTS
    link: int | None = None
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    twice: bool = False
    press: float | None = None
    untouched: tuple[float, float] | None = None
    later: Mapping[str, Any] = field(default_factory=dict)
    plan: Mapping[str, Any] = field(default_factory=dict)
    constants: Mapping[str, Any] = field(default_factory=dict)
    noise: float = 0.0
    step: float = 0.0
    late: float = 0.0
    compliance: float = 0.0
    backlash: float = 0.0
    beside: str | None = None
    about: tuple[float, ...] = POSTURE

    @property
    def arms(self) -> list[str]:
        """The arms of the study."""
        return [self.arm] + ([self.beside] if self.beside else [])


def rubbing(factor: float) -> Plan:
    """Return the keys for friction multiplied by a factor."""
    return {"coulomb_factor": [factor] * 6, "viscous_factor": [factor] * 6}


def load(mass: float) -> Plan:
    """Return the keys for an undeclared load [kg]."""
    return {"undeclared_payload": {"mass": mass, "center_of_mass": [0.02, 0.0, 0.06]}}


SEVEN, SENSING = "seven-joints", "ur5e-torques"  # arms that only these studies have
ABOUT = 0.3, 0.6, 0.2, -1.2, 0.2, 1.0, 0.3  # rad; elbow and wrist of the former are bent
WARMING = 25.0, 40.0  # °C, in each recording
FRICTION, DRIVE = "ur5lib.stand.friction", "ur5lib.stand.drive"
SITUATIONS: dict[str, Situation] = {
    "tool of 0 cm, known": Situation(tool=0.0, declared=0.0),
    "tool of 8 cm, known": Situation(),
    "tool of 15 cm, known": Situation(tool=0.15, declared=0.15),
    "tool of 25 cm, known": Situation(tool=0.25, declared=0.25),
    "tool of 8 cm, unknown": Situation(declared=None),
    "tool of 15 cm, unknown": Situation(tool=0.15, declared=None),
    "tool of 25 cm, unknown": Situation(tool=0.25, declared=None),
    "tool of 8 cm, taken for 13": Situation(declared=0.13),
    "undeclared load of 0.5 kg": Situation(later=load(0.5)),
    "undeclared load of 2 kg": Situation(later=load(2.0)),
    "UR3e": Situation(arm="ur3e"),
    "UR10e on a wall": Situation(arm="ur10e", mounting="wall"),
    "UR16e under a ceiling": Situation(arm="ur16e", mounting="ceiling"),
    "UR20": Situation(arm="ur20"),
    "friction × 0.3": Situation(plan=rubbing(0.3)),
    "friction × 3": Situation(plan=rubbing(3.0)),
    "friction of another day": Situation(later=rubbing(1.25)),
    "friction of loaded gears": Situation(constants={f"{FRICTION}.LOAD_SHARE": 0.15}),
    "friction reverses in 4 µrad": Situation(constants={f"{FRICTION}.PRESLIDING_DEFLECTION": 4e-6}),
    "friction reverses in 2 mrad": Situation(constants={f"{FRICTION}.PRESLIDING_DEFLECTION": 2e-3}),
    "no stops in the fits": Situation(stops=0),
    "stops in one fit": Situation(stops=1),
    "one path": Situation(paths=1, stops=0),
    "seven paths of 8 s": Situation(paths=7, seconds=8.0),
    "25 Hz": Situation(rate=25),
    "500 Hz": Situation(rate=500),
    "noise × 5": Situation(noise=0.25),
    "steps of 10 mA": Situation(step=0.01),
    "ripple × 3": Situation(constants={f"{DRIVE}.CURRENT_RIPPLE": 3 * CURRENT_RIPPLE}),
    "short pushes": Situation(lasts=0.3),
    "long pushes": Situation(lasts=3.5),
    "weak pushes": Situation(forces=(0.3, 1.0)),
    "slow press, tared": Situation(press=15.0, untouched=(0.0, 1.5)),
    "slow press": Situation(press=15.0),
    "pushes at the elbow": Situation(link=3),
    "pushes at the forearm": Situation(link=3, point=(0.196, 0.0, 0.0)),
    "pushes hidden in a fit": Situation(hidden=1),
    "pushes hidden in two fits": Situation(hidden=2),
    "two pushes at once": Situation(twice=True),
    "pushes hidden in all fits": Situation(hidden=3),
    "motors warm up by 15 °C": Situation(plan={"temperature_c": WARMING}),
    "joints of 5 kNm/rad": Situation(compliance=2e-4),
    "backlash of 1 mrad": Situation(backlash=1e-3),
    "joint 3 is 40 ms late": Situation(late=0.04),
    "seven joints": Situation(arm=SEVEN, about=ABOUT),
    "joint torque sensors": Situation(arm=SENSING),
    "a UR3e beside it": Situation(beside="ur3e"),
}


@contextmanager
def described(arms: Collection[str]) -> Iterator[None]:
    """Provide the descriptions of those arms that only these studies have, where a study finds
    them: an arm of seven joints, and a UR5e that measures its joints' torques.
    """
    sensing = (
        robot_path("ur5e").read_text(encoding="utf-8").replace("name: ur5e", f"name: {SENSING}")
    )
    texts = {
        SEVEN: (Path(__file__).parent / f"{SEVEN}.yaml").read_text(encoding="utf-8"),
        SENSING: f"{sensing}\neffort: joint_torque\n",
    }
    made = [PROJECT_FOLDER / f"{name}.yaml" for name in texts if name in arms]
    try:
        for file in made:
            write_text(texts[file.stem], file)
        yield
    finally:
        for file in made:
            file.unlink(missing_ok=True)
        if made and not [*PROJECT_FOLDER.iterdir()]:
            PROJECT_FOLDER.rmdir()


def plans(own: Situation, seed: Sequence[int], arm: Robot) -> Iterator[tuple[str, str, Plan]]:
    """Yield name, role and plan of the stand of each recording of a situation."""
    random = np.random.default_rng(seed)
    force = typical_force(arm)
    for k in range(own.paths):
        stops = k >= own.paths - own.stops
        share = 0.5 if k % 2 == 0 else 0.2
        motion = way_points(random, PAUSE, own.about) if stops else fourier(own, random, share)
        plan = {"trajectory": motion, "seconds": own.seconds, **own.plan}
        if k < own.hidden:
            plan |= {"contacts": [*pushes(own, random, force, HIDDEN)]}
        yield f"fit-{k + 1}", "fit", plan
    other = {**own.plan, **own.later}
    free = {"trajectory": way_points(random, PAUSE, own.about), "seconds": FIT_SECONDS}
    yield "free", "validate", free | other
    length = START + EVERY * MOVING
    moving = {"trajectory": fourier(own, random, 0.5, length), "seconds": length}
    yield "moving", "contact", moving | other | {"contacts": [*pushes(own, random, force, MOVING)]}
    resting = {"trajectory": {"kind": "standstill", "posture": posture(random, own.about)}}
    contacts = [*pushes(own, random, force, RESTING)]
    length = START + EVERY * RESTING
    if own.press:
        length = own.press + 4.0
        contacts = [push(own, random, 2.5 * force, START, own.press)]
    yield "resting", "contact", resting | other | {"seconds": length, "contacts": contacts}


def pushes(own: Situation, random: np.random.Generator, force: float, count: int) -> Iterator[Plan]:
    """Yield pushes, one every EVERY seconds; force: typical [N]."""
    for k in range(count):
        for _ in range(1 + own.twice):
            size = np.exp(random.uniform(*np.log(own.forces))) * force
            yield push(own, random, size, START + EVERY * k, own.lasts)


def push(
    own: Situation, random: np.random.Generator, size: float, start: float, seconds: float
) -> Plan:
    """Return a push of this force [N] in a drawn direction."""
    way = random.normal(size=3)
    where: Plan = {"point": [0.0, 0.0, own.tool]}
    if own.link:
        where = {"link": own.link, "point": [*own.point]}
    force = (size * way / np.linalg.norm(way)).tolist()
    return {"kind": "push", "force": force, "start_s": start, "seconds": seconds} | where


def fourier(
    own: Situation, random: np.random.Generator, share: float, seconds: float | None = None
) -> Plan:
    """Return a drawn excitation; seconds: its length, None: that of a fit."""
    period = min(seconds or own.seconds, MAX_PERIOD)
    return drawn_studies.fourier(random, share, period, own.about) | {"harmonics": HARMONICS}

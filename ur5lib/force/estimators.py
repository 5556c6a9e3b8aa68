"""The estimators of the contact wrench: their names, and what each states of a recording.

Records, thresholds, tables, figures, the comparison with simulated truth and the benchmark take
ESTIMATORS in this order; the first that a recording has leads its figures and sentences.
"""

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from ur5lib.errors import InputError
from ur5lib.timeseries.arrays import Array
from ur5lib.workspace.extensions import PAGE, additions

if TYPE_CHECKING:  # to read estimates, the code that makes them is not loaded
    from ur5lib.force.wrench_estimate import WrenchEstimate
    from ur5lib.records.currents import Currents
    from ur5lib.records.dynamics import Kinematics
    from ur5lib.records.forces import Forces
    from ur5lib.records.motion import Motion


class Stated(NamedTuple):
    """What an estimator states: the wrench of the environment on the arm, base axes, at the origin
    of frame 6.

    wrench and std, its standard deviation: (N, 6) [N, Nm], NaN where there is no estimate; std is
    None if the estimator states none; log_odds: (N,), of contact, None if it states no odds;
    unsmoothed: (N, 3) [N], the force for peaks, None if it is that of `wrench`.
    """

    wrench: Array
    std: Array | None = None
    log_odds: Array | None = None
    unsmoothed: Array | None = None

    @property
    def sharp(self) -> Array:
        """Return the force (N, 3) [N] for peaks."""
        return self.wrench[:, :3] if self.unsmoothed is None else self.unsmoothed


def all_stated(forces: "Forces", others: Mapping[str, Array]) -> dict[str, Stated]:
    """Return what every estimate of a recording states, by name.

    others: wrenches (N, 6) without bands and odds, as the controller's and the thesis's.
    """
    ours = {
        name: Stated(wrench, forces.std.get(name), forces.log_odds.get(name))
        for name, wrench in forces.wrench.items()
    }
    if LEADING in ours:
        ours[LEADING] = ours[LEADING]._replace(unsmoothed=forces.unsmoothed)
    return {name: Stated(wrench) for name, wrench in others.items()} | ours


# WrenchEstimate has the fields of Stated; None: the recording lacks what the estimator needs.
Answer: TypeAlias = "Stated | WrenchEstimate | None"


@dataclass(frozen=True)
class Run:
    """What estimators use of a recording.

    motion: smoothed, with its `time` (N,); currents: predicted, and the external torques from them;
    kinematics: of the flange at that motion; controller: the wrench (N, 6) [N, Nm] that the
    controller computes from currents, None if not recorded; fmap: F̂ᵐᵃᵖ, None without its problem;
    static: the estimate without any fit, None if friction was fitted.
    """

    motion: "Motion"
    currents: "Currents"
    kinematics: "Kinematics"
    controller: Array | None = None
    fmap: "WrenchEstimate | None" = None
    static: Stated | None = None

    @property
    def background(self) -> Array | None:
        """Return the slow external torque (N, 6) [Nm] by F̂ᵐᵃᵖ, which is no contact; None without
        F̂ᵐᵃᵖ.
        """
        return None if self.fmap is None else self.fmap.background


@dataclass(frozen=True)
class Estimator:
    """One estimator of the contact wrench.

    label: its name in reports; estimate: returns its estimate of a run; gated: whether that has
    log-odds of contact, and so raises alarms; article: text before the label in sentences.
    """

    label: str
    estimate: Callable[[Run], Answer]
    gated: bool = True
    article: str = ""


def least_squares(run: Run) -> Answer:
    """Return the wrench by least squares in the contacts that F̂ᵐᵃᵖ finds; None without F̂ᵐᵃᵖ."""
    fmap = run.fmap
    return None if fmap is None else Stated(fmap.least_squares, fmap.least_squares_std)


def controller(run: Run) -> Answer:
    """Return the wrench that an e-Series controller computes from currents,
    `wrench_calc_from_currents`; None if not recorded.

    Public files state the output's name and type, and that it is a wrench (RTDE guide;
    Universal_Robots_Client_Library, tests/fake_rtde_server.cpp), but not frame, point nor sign.
    They are taken to be those of the same controller's `actual_TCP_force`: the environment acting
    on the arm, at the flange, which is the origin of frame 6, in base axes
    (Universal_Robots_ROS2_Driver, pull request 1615).
    """
    return None if run.controller is None else Stated(run.controller)


def added(shipped: Collection[str]) -> dict[str, Estimator]:
    """Return, by name, the estimators that the workspace's extensions add. Raises InputError where
    one cannot be used.
    """
    found = {}
    for source, name, one in additions("estimators"):
        if not re.fullmatch(r"[a-z]\w*", name) or name in {*shipped, *PUBLISHED}:
            raise InputError(
                f"{source}: {name!r} is an estimator of ur5lib, or no lower-case word; rename it"
            )
        if not isinstance(one, Estimator):
            raise InputError(f"{source}: {name!r} is no Estimator; {PAGE}")
        found[name] = replace(one, estimate=partial(checked, one, f"{source}: {name!r}"))
    return found


def checked(estimator: Estimator, place: str, run: Run) -> Answer:
    """Return what an estimator states of a run. Raises InputError for an array with a wrong shape.

    place: names the estimator in the message.
    """
    found = estimator.estimate(run)
    if found is None:
        return None
    count = len(run.motion.time)
    shapes = {"wrench": (count, 6), "std": (count, 6), "log_odds": (count,)}
    needed = ("wrench", "log_odds") if estimator.gated else ("wrench",)
    for name, shape in shapes.items():
        values: Array | None = getattr(found, name, None)
        if name in needed if values is None else np.shape(values) != shape:
            own = "no" if values is None else f"a {np.shape(values)}"
            raise InputError(
                f"{place} states {own} `{name}`, where {shape} is needed; return Stated of all "
                "samples, or None for no estimate"
            )
    return found


PUBLISHED = {"Fu": "F̂ᵘ", "F": "F̂", "F*": "F̂*"}  # the controller's and the thesis's
ESTIMATORS = {  # their keys are the names in records and tables
    "Fmap": Estimator("F̂ᵐᵃᵖ", lambda run: run.fmap),
    "least_squares": Estimator("gated least squares", least_squares, gated=False),
    "static": Estimator("uncalibrated static estimate", lambda run: run.static, False, "the "),
    "controller_currents": Estimator(
        "controller, from currents", controller, False, "the force by the "
    ),
}
OWN = added(ESTIMATORS)
ESTIMATORS |= OWN
NEW = {name: one.label for name, one in ESTIMATORS.items()}
STATIC = "static"  # the estimate without any fit
UNGATED = "ungated_least_squares"  # the baseline of all others, computed where there is a sensor
ESTIMATES = PUBLISHED | NEW | {UNGATED: "plain least squares"}
SPOKEN = PUBLISHED | {"Fu": "the controller's F̂ᵘ"}
SPOKEN |= {name: one.article + one.label for name, one in ESTIMATORS.items()}
GATED = [name for name, one in ESTIMATORS.items() if one.gated]
LEADING = GATED[0]  # a study's contacts, alarms and smallest pushes are by this one

"""The estimators of the contact wrench: their names, and what each states of a recording.

Records, thresholds, tables, figures, the comparison with simulated truth and the benchmark take
ESTIMATORS as they stand here; the first that a recording has leads its figures and sentences.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from ur5lib.timeseries.arrays import Array

if TYPE_CHECKING:  # whoever reads estimates need not load what makes them
    from ur5lib.force.wrench_estimate import WrenchEstimate


class Stated(NamedTuple):
    """The environment on the arm, base axes, at the origin of frame 6.

    wrench and std, its standard deviation: (N, 6) [N, Nm], NaN where nothing is known; std is None
    of an estimator that states none; log_odds: (N,), that there is a contact, None of an estimator
    that is not gated.
    """

    wrench: Array
    std: Array | None = None
    log_odds: Array | None = None


# The second states the same; None where the recording lacks what the estimator needs.
Answer: TypeAlias = "Stated | WrenchEstimate | None"


@dataclass(frozen=True)
class Run:
    """A recording, as far as its estimators share it.

    solved: the most probable wrenches by the external torque, the observer's, and less that of
    other runs; causal_odds: log-odds (N,) of contact from past currents; static: the estimate
    without any fit, where there is none; controller: the wrench (N, 6) [N, Nm] that the controller
    computes from currents, where it was recorded.
    """

    solved: "Mapping[str, WrenchEstimate]" = field(default_factory=dict)
    causal_odds: Array | None = None
    static: Stated | None = None
    controller: Array | None = None

    @property
    def background(self) -> Array | None:
        """Return the slow external torque (N, 6) [Nm] that is no contact, by F̂ᵐᵃᵖ."""
        return self.solved["Fmap"].background if "Fmap" in self.solved else None


@dataclass(frozen=True)
class Estimator:
    """One estimator of the contact wrench.

    name: in records and tables; label: in reports; gated: whether it states odds of contact, so
    that it raises alarms; article: before the label in sentences.
    """

    name: str
    label: str
    estimate: Callable[[Run], Answer]
    gated: bool = True
    article: str = ""


def solved(name: str) -> Callable[[Run], Answer]:
    """Return an estimator: the most probable wrench by the torque of a name in `Run.solved`."""
    return lambda run: run.solved.get(name)


def least_squares(run: Run) -> Answer:
    """Return the wrench by least squares, in the contacts of F̂ᵐᵃᵖ."""
    fmap = run.solved.get("Fmap")
    return None if fmap is None else Stated(fmap.least_squares, fmap.least_squares_std)


def controller(run: Run) -> Answer:
    """Return what an e-Series controller computes from currents, `wrench_calc_from_currents`.

    Of this output, the field's public files state name, type and that it is a wrench (RTDE guide;
    Universal_Robots_Client_Library, tests/fake_rtde_server.cpp), not frame, point nor sign. They
    are taken to be those of the same controller's `actual_TCP_force`: the environment acting on
    the arm, at the flange, which is the origin of frame 6, in base axes
    (Universal_Robots_ROS2_Driver, pull request 1615).
    """
    return None if run.controller is None else Stated(run.controller)


ESTIMATORS = (
    Estimator("Fmap", "F̂ᵐᵃᵖ", solved("Fmap")),
    Estimator("least_squares", "least squares", least_squares, gated=False),
    Estimator("observer", "observer", solved("observer")),
    Estimator("repeat", "repeat-aware", solved("repeat")),
    Estimator("static", "uncalibrated static estimate", lambda run: run.static, False, "the "),
    Estimator(
        "controller_currents", "controller, from currents", controller, False, "the force by the "
    ),
)
PUBLISHED = {"Fu": "F̂ᵘ", "F": "F̂", "F*": "F̂*"}  # the controller's and the thesis's
NEW = {one.name: one.label for one in ESTIMATORS}
ESTIMATES = PUBLISHED | NEW
SPOKEN = PUBLISHED | {one.name: one.article + one.label for one in ESTIMATORS}  # as in sentences
GATED = [one.name for one in ESTIMATORS if one.gated]

"""The information that a recording along a path would add about an arm."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ur5lib.excitation.objective import STEP, Task
from ur5lib.excitation.path import Path
from ur5lib.timeseries.arrays import Array, Labels, Mask

HARDLY = 0.9  # share of a standard error above which a recording hardly lowers it


@dataclass(frozen=True)
class Worth:
    """The information that a recording would add to the prior and to earlier recordings.

    log_det: log det of the information M (P, P) after the recording; gain: increase by the
    recording; regressor_condition: condition number of the base parameters' regressor in SI units
    (Gautier 1992); condition: condition number of J, each column in units of its prior standard
    deviation; prior, before, after: standard errors (P,) of `Problem.names` in physical units, by
    the prior alone, before the recording, and after it.
    """

    log_det: float
    gain: float
    regressor_condition: float
    condition: float
    prior: Array
    before: Array
    after: Array

    def least_determined(self) -> Labels:
        """Return the indices (P,) that sort the parameters, the least determined first.

        By the ratio to the prior's standard error before the recording; equal ones by that after.
        """
        return np.lexsort([-self.after / self.prior, -np.round(self.before / self.prior, 9)])

    def hardly_lowered(self) -> Mask:
        """Return which parameters (P,) keep most of their standard error after the recording."""
        return np.asarray(self.after > HARDLY * self.before)

    @classmethod
    def along(cls, task: Task, path: Path) -> Self:
        """Return the worth of a path for a task."""
        problem, (_, states) = task.problem, path.sampled(1 / STEP)
        Y = task.cell.model.regressor(states.q, states.qd, states.qdd)
        W = Y[..., problem.base.columns].reshape(-1, problem.count)
        J = problem.rows(problem.theta, Y, states.qd).reshape(-1, len(problem.theta))
        width = np.sqrt(np.diag(np.linalg.inv(problem.prior)))
        information = task.information(path)
        log_det, earlier = (np.linalg.slogdet(one)[1] for one in (information, task.earlier))
        return cls(
            log_det=float(log_det),
            gain=float(log_det - earlier),
            regressor_condition=float(np.linalg.cond(W)),
            condition=float(np.linalg.cond(J * width)),
            prior=problem.standard_errors(problem.prior),
            before=problem.standard_errors(task.earlier),
            after=problem.standard_errors(information),
        )

"""What a recording along a path would be worth."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ur5lib.excitation.objective import STEP, Task
from ur5lib.excitation.path import Path
from ur5lib.timeseries.arrays import Array, Labels


@dataclass(frozen=True)
class Worth:
    """What a recording along a path would be worth, in addition to earlier ones.

    log_det: of the information M (P, P) with the recording; gain: of it, by the recording;
    regressor_condition: condition number of the base
    parameters' regressor (Gautier 1992); condition: of J with all columns in units of their
    prior standard deviation; prior, before, after: standard errors (P,) of `Problem.names`, in
    physical units, of the prior, without and with the recording.
    """

    log_det: float
    gain: float
    regressor_condition: float
    condition: float
    prior: Array
    before: Array
    after: Array

    def least_determined(self) -> Labels:
        """Return the order of the parameters (P,), those first of which least is known so far.

        By the share of the prior's standard error that was left before, then after the recording.
        """
        return np.lexsort([-self.after / self.prior, -np.round(self.before / self.prior, 9)])

    @classmethod
    def of(cls, task: Task, path: Path) -> Self:
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

"""Contact wrench from the external torque, with its band and the odds that there is a contact."""

from typing import Any

from ur5lib.pipeline.estimators import ESTIMATORS, Stated
from ur5lib.pipeline.force_run import ForceRun
from ur5lib.pipeline.records.forces import Forces
from ur5lib.pipeline.records.motion import Motion
from ur5lib.timeseries.arrays import Array


def estimate_forces(input: Any, output: Any, params: Any) -> None:
    known = _estimates(input, params)
    # read anew, so that of a long recording either all inputs are held or all results
    Forces.of(Motion.read(input.motion), *known).write(output.forces)


def _estimates(input: Any, params: Any) -> tuple[dict[str, Stated], Array | None, Array | None]:
    """Return the estimates by name, the slow external torque, and the causal odds of contact."""
    run = ForceRun(input, params)
    stated = {one.name: one.estimate(run) for one in ESTIMATORS}
    found = {name: one for name, one in stated.items() if one is not None}
    return found, None if run.fmap is None else run.fmap.background, run.causal_odds()

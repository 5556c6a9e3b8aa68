"""How far the external torque is from zero where nothing touches the arm."""

from typing import Any

from ur5lib.errors import InputError
from ur5lib.force.residual_model import Stretch, few_paths, fit_residual_model
from ur5lib.force.template import Run
from ur5lib.identification.currents import CurrentFit, breakaway_torque
from ur5lib.pipeline.force_run import force_run
from ur5lib.steps import run_step
from ur5lib.tables import read_json, read_table, write_json
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import unbroken

TORQUES = ["tau_ext", "tau_observer"]
ONE_PATH = (
    "all recordings to fit on are of one path: how far the arm's torque strays on others is not "
    "known, so bands and gate are 6.5 times as wide as that path alone says; record another path"
)


def fit_residuals(input: Any, output: Any, params: Any) -> None:
    friction = read_json(input.friction)
    summary: dict[str, Any] = {}
    if friction["from"]:
        tables = [
            (read_table(currents), read_table(motion))
            for currents, motion in zip(input.currents, input.motion, strict=True)
        ]
        breakaway = breakaway_torque(CurrentFit.from_plain(friction["fit"]))
        for torque in TORQUES:
            runs = [force_run(currents, motion, torque) for currents, motion in tables]
            found = [run for run in runs if run is not None]
            summary |= residuals(torque, found, breakaway, friction["paths"], params.cutoff_hz)
        if friction["paths"] == 1 and "refused" not in summary:
            summary["remarks"] = [ONE_PATH]
    write_json(summary, output.residuals)


def residuals(
    torque: str, runs: list[Run], breakaway: Array, paths: int, cutoff: float
) -> dict[str, Any]:
    """The residual model of a torque, by predictions that have not seen the path; or why none."""
    stretches = [
        Stretch(run.torque[rows], run.states[rows], run.period)
        for run in runs
        for rows in unbroken(run.segment)
    ]
    try:
        model = fit_residual_model(stretches, cutoff, breakaway)
    except InputError as error:  # too little without contact: then no force is estimated
        return {"refused": str(error)}
    return {torque: model.wider(few_paths(paths)).to_dict()}


if __name__ == "__main__":
    run_step(fit_residuals, snakemake)  # type: ignore[name-defined]  # noqa: F821

"""How far the external torque is from zero where nothing touches the arm."""

from typing import Any

from ur5lib.errors import InputError
from ur5lib.force.external_torque import unbroken
from ur5lib.force.residual_model import fit_residual_model
from ur5lib.force_run import force_run
from ur5lib.steps import run_step
from ur5lib.tables import period, read_table, write_json

TORQUES = ["tau_ext", "tau_observer"]


def fit_residuals(input: Any, output: Any, params: Any) -> None:
    tables = [
        (read_table(currents), read_table(motion))
        for currents, motion in zip(input.currents, input.motion, strict=True)
    ]
    summary: dict[str, Any] = {}
    for torque in TORQUES:
        tried = [force_run(currents, motion, torque) for currents, motion in tables]
        runs = [run for run in tried if run is not None]
        if not runs:
            continue  # without currents, as the fit of friction says
        stretches = [
            (run.torque[rows], run.states[rows]) for run in runs for rows in unbroken(run.segment)
        ]
        try:
            step = period(tables[0][1])
            model = fit_residual_model(stretches, step, params.cutoff_hz)
            summary[torque] = model.to_dict()
        except InputError as error:  # too little without contact: then no force is estimated
            summary["refused"] = str(error)
    write_json(summary, output.residuals)


if __name__ == "__main__":
    run_step(fit_residuals, snakemake)  # type: ignore[name-defined]  # noqa: F821

"""Contact wrench from the external torque, with its band and the odds that there is a contact."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.template import Run, repeat_aware
from ur5lib.force.wrench_estimate import WrenchEstimate, estimate_wrench
from ur5lib.pipeline.force_run import force_run
from ur5lib.steps import run_step
from ur5lib.tables import (
    WRENCH,
    channel,
    labelled,
    named,
    period,
    read_json,
    read_table,
    write_table,
)
from ur5lib.timeseries.arrays import Array

ALIKE = 1.96  # standard errors between the masses of runs that may carry the same


def estimate_forces(input: Any, output: Any, params: Any) -> None:
    motion, residuals = read_table(input.motion), read_json(input.residuals)
    jacobian = channel(read_table(input.kinematics), "J", 36).reshape(-1, 6, 6)
    prior = ContactPrior(force=params.contact_force_n)
    columns: dict[str, Array] = {}
    for name, run, model in problems(input, motion, residuals, params):
        estimate = estimate_wrench(
            run.torque, jacobian, run.states, run.segment, period(motion), model, prior, run.doubt
        )
        columns |= as_columns(name, estimate)
        if name == "Fmap":
            columns |= labelled(estimate.least_squares, "least_squares", WRENCH)
            columns |= labelled(estimate.least_squares_std, "least_squares_std", WRENCH)
            columns |= named(estimate.background, "tau_background")
    write_table(motion[["time", "segment"]].join(pd.DataFrame(columns)), output.forces)


def problems(
    input: Any, motion: pd.DataFrame, residuals: Any, params: Any
) -> Iterator[tuple[str, Run, ResidualModel]]:
    """Each estimate's external torque and what is known of it without contact.

    F̂ᵐᵃᵖ; the momentum observer; and where contact-free recordings pass the same trajectory with
    the same payload, F̂ᵐᵃᵖ with their residual taken off.
    """
    currents = read_table(input.currents)
    for name, torque in (("Fmap", "tau_ext"), ("observer", "tau_observer")):
        run = force_run(currents, motion, torque)
        if run is not None and torque in residuals:
            yield name, run, ResidualModel.from_dict(residuals[torque])
    run = force_run(currents, motion, "tau_ext")
    if run is None or "tau_ext" not in residuals:
        return
    alike = [same_load(input.load, other) for other in input.free_loads]
    others = [
        force_run(read_table(currents), read_table(motion), "tau_ext")
        for currents, motion, same in zip(
            input.free_currents, input.free_motion, alike, strict=True
        )
        if same
    ]
    free = [other for other in others if other is not None]
    model = ResidualModel.from_dict(residuals["tau_ext"])
    found = repeat_aware(run, free, model, params.cutoff_hz)
    if found is not None:
        yield "repeat", run.with_torque(found.torque, found.states), found.model


def same_load(own: str, other: str) -> bool:
    """Whether two recordings may carry the same, by their currents.json; not where unknown."""
    loads = [read_json(path).get("load") for path in (own, other)]
    if None in loads:
        return False
    mass, error = (np.array([load[name] for load in loads]) for name in ("carried", "std_error"))
    return bool(abs(mass[1] - mass[0]) <= ALIKE * np.hypot(*error))


def as_columns(name: str, estimate: WrenchEstimate) -> dict[str, Array]:
    """Wrench, standard deviation and log-odds of contact, as named columns."""
    columns = labelled(estimate.wrench, name, WRENCH)
    columns |= labelled(estimate.std, f"{name}_std", WRENCH)
    columns |= {f"log_odds_{name}": estimate.log_odds}
    return columns | {f"causal_log_odds_{name}": estimate.causal_log_odds}


if __name__ == "__main__":
    run_step(estimate_forces, snakemake)  # type: ignore[name-defined]  # noqa: F821

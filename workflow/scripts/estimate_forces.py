"""Contact wrench from the external torque, with its band and the odds that there is a contact."""

from collections.abc import Iterator
from typing import Any

import pandas as pd

from ur5lib.force.hypotheses import ContactPrior
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.template import Run, repeat_aware
from ur5lib.force.wrench_estimate import WrenchEstimate, estimate_wrench
from ur5lib.force_run import force_run
from ur5lib.metrics import Array
from ur5lib.steps import run_step
from ur5lib.tables import WRENCH, channel, labelled, period, read_json, read_table, write_table


def estimate_forces(input: Any, output: Any, params: Any) -> None:
    motion, residuals = read_table(input.motion), read_json(input.residuals)
    jacobian = channel(read_table(input.kinematics), "J", 36).reshape(-1, 6, 6)
    prior = ContactPrior(force=params.contact_force_n, lever=params.contact_lever_m)
    columns: dict[str, Array] = {}
    for name, run, model in problems(input, motion, residuals, params):
        estimate = estimate_wrench(
            run.torque, jacobian, run.states, run.segment, period(motion), model, prior
        )
        columns |= as_columns(name, estimate)
    write_table(motion[["time", "segment"]].join(pd.DataFrame(columns)), output.forces)


def problems(
    input: Any, motion: pd.DataFrame, residuals: Any, params: Any
) -> Iterator[tuple[str, Run, ResidualModel]]:
    """Each estimate's external torque and what is known of it without contact.

    F̂ᵐᵃᵖ; the momentum observer; and where contact-free recordings pass the same trajectory,
    F̂ᵐᵃᵖ with their residual taken off.
    """
    currents = read_table(input.currents)
    for name, torque in (("Fmap", "tau_ext"), ("observer", "tau_observer")):
        run = force_run(currents, motion, torque)
        if run is not None and torque in residuals:
            yield name, run, ResidualModel.from_dict(residuals[torque])
    run = force_run(currents, motion, "tau_ext")
    if run is None or "tau_ext" not in residuals:
        return
    others = [
        force_run(read_table(currents), read_table(motion), "tau_ext")
        for currents, motion in zip(input.free_currents, input.free_motion, strict=True)
    ]
    free = [other for other in others if other is not None]
    model = ResidualModel.from_dict(residuals["tau_ext"])
    found = repeat_aware(run, free, model, period(motion), params.cutoff_hz)
    if found is not None:
        yield "repeat", Run(run.q, run.qd, found.torque, found.states, run.segment), found.model


def as_columns(name: str, estimate: WrenchEstimate) -> dict[str, Array]:
    """Wrench, standard deviation and log-odds of contact, as named columns."""
    columns = labelled(estimate.wrench, name, WRENCH)
    columns |= labelled(estimate.std, f"{name}_std", WRENCH)
    return columns | {f"log_odds_{name}": estimate.log_odds}


if __name__ == "__main__":
    run_step(estimate_forces, snakemake)  # type: ignore[name-defined]  # noqa: F821

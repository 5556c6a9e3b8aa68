"""The map from motion to motor current: torque constants and friction, over recordings to fit."""

from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.current_record import current_record, smoother
from ur5lib.identification.currents import fit_currents, parameters
from ur5lib.identification.friction import FAMILY
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import Record
from ur5lib.identification.torque_constants import standstill_ratio, torque_constant_prior
from ur5lib.identification.validation import fitted_on_tested_on, least_squares_coefficients
from ur5lib.metrics import Array
from ur5lib.robots.description import Robot, load_robot
from ur5lib.steps import run_step
from ur5lib.tables import channel, read_table, write_json

# Relative: of the maker's constants, among joints with motors of one size, of the controller's.
WIDTHS = (0.3, 0.1, 0.1)


def fit_friction(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    records, ratios = [], []
    for name, *paths in zip(
        params.recordings, input.signals, input.motion, input.torques, strict=True
    ):
        signals, motion, torques = map(read_table, paths)
        record = current_record(name, signals, motion, torques, robot.fullest_model())
        if record is not None:
            records.append(record)
            ratios.append(controllers_ratio(signals, record.qd))
    summary: dict[str, Any] = {"from": []}
    try:
        prior = prior_of(robot, ratios)
        summary = fitted(records, prior, params) | {"model": robot.fullest_model()}
    except ValueError as error:
        summary["refused"] = str(error)
    write_json(summary, output.friction)


def controllers_ratio(signals: pd.DataFrame, qd: Array) -> Array:
    """The controller's own torque constants (6,) [Nm/A], as far as a recording shows them."""
    if "target_moment_0" not in signals or "target_current_0" not in signals:
        return np.full(6, np.nan)
    moment, current = channel(signals, "target_moment"), channel(signals, "target_current")
    return standstill_ratio(moment, current, qd)


def prior_of(robot: Robot, ratios: list[Array]) -> Prior:
    """What is known before the fit. Raises ValueError where that is too little, or no recording."""
    if not ratios:
        raise ValueError("no recording with role `fit` has motor currents")
    columns = [column[np.isfinite(column)] for column in np.array(ratios).T]
    controller = np.array([np.median(column) if len(column) else np.nan for column in columns])
    maker = np.array(robot.maker_torque_constants())
    torque_max = np.array([robot.motor(joint).torque_max for joint in range(1, 7)])
    return Prior(torque_constant_prior(maker, controller, robot.joints, WIDTHS), torque_max)


def fitted(records: list[Record], prior: Prior, params: Any) -> dict[str, Any]:
    """The fit, its parameters in SI units, a baseline, and each recording's fit on the others."""
    smooth = smoother(params.order, params.cutoff_hz)
    family = [term for term in FAMILY if term.kind in params.terms]
    fit = fit_currents(records, smooth, prior, family)
    shapes = [joint.terms for joint in fit.joints], [joint.presliding for joint in fit.joints]
    return {
        "from": [record.name for record in records],
        "fit": asdict(fit),
        "parameters": list(map(asdict, parameters(fit))),
        "least_squares": least_squares_coefficients(records),
        "cross_validation": fitted_on_tested_on(records, smooth, prior, *shapes),
    }


if __name__ == "__main__":
    run_step(fit_friction, snakemake)  # type: ignore[name-defined]  # noqa: F821

"""The map from motion to motor current: torque constants and friction, over recordings to fit."""

from dataclasses import asdict
from typing import Any

from ur5lib.identification.currents import fit_currents, fit_without_each_path, parameters
from ur5lib.identification.friction import FAMILY
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import Record, record_paths
from ur5lib.identification.validation import fitted_on_tested_on, least_squares_coefficients
from ur5lib.pipeline.current_prior import controllers_ratio, prior_of
from ur5lib.pipeline.current_record import current_record, smoother
from ur5lib.robots.description import load_robot
from ur5lib.steps import run_step
from ur5lib.tables import read_table, write_json


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


def fitted(records: list[Record], prior: Prior, params: Any) -> dict[str, Any]:
    """The fit, the same without each path, its parameters in SI units, and baselines."""
    smooth = smoother(params.order, params.cutoff_hz)
    family = [term for term in FAMILY if term.kind in params.terms]
    fit = fit_currents(records, smooth, prior, family)
    shapes = [joint.terms for joint in fit.joints], [joint.presliding for joint in fit.joints]
    return {
        "from": [record.name for record in records],
        "paths": int(record_paths(records).max()) + 1,
        "fit": asdict(fit),
        "left_out": [
            {"recordings": names, "fit": without_replicates(asdict(own))}
            for names, own in fit_without_each_path(records, smooth, prior, family)
        ],
        "parameters": list(map(asdict, parameters(fit))),
        "least_squares": least_squares_coefficients(records),
        "cross_validation": fitted_on_tested_on(records, smooth, prior, *shapes),
    }


def without_replicates(fit: dict[str, Any]) -> dict[str, Any]:
    """A fit as plain data that predicts, but no longer says how certain it is."""
    for joint in fit["joints"]:
        joint["estimate"]["replicates"] = joint["estimate"]["replicates"][:1]
    return fit


if __name__ == "__main__":
    run_step(fit_friction, snakemake)  # type: ignore[name-defined]  # noqa: F821

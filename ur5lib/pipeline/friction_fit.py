"""The fit of torque constants and friction, as friction.json holds it."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from ur5lib.identification.currents import fit_currents, fit_without_each_path, parameters
from ur5lib.identification.friction import FAMILY
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import Record, Smooth, record_paths
from ur5lib.identification.validation import fitted_on_tested_on, least_squares_coefficients


def friction_summary(
    records: Sequence[Record], prior: Prior, smooth: Smooth, terms: Sequence[str]
) -> dict[str, Any]:
    """Return the fit, the same without each path, its parameters in SI units, and baselines.

    terms: of friction, from which the fit chooses.
    """
    family = [term for term in FAMILY if term.kind in terms]
    fit = fit_currents(records, smooth, prior, family)
    shapes = [joint.terms for joint in fit.joints], [joint.presliding for joint in fit.joints]
    return {
        "from": [record.name for record in records],
        "paths": int(record_paths(records).max()) + 1,
        "fit": asdict(fit),
        "left_out": [
            {"recordings": names, "fit": _without_replicates(asdict(own))}
            for names, own in fit_without_each_path(records, smooth, prior, family)
        ],
        "parameters": list(map(asdict, parameters(fit))),
        "least_squares": least_squares_coefficients(records),
        "cross_validation": fitted_on_tested_on(records, smooth, prior, *shapes),
    }


def _without_replicates(fit: dict[str, Any]) -> dict[str, Any]:
    """Return a fit as plain data without its bootstrap replicates, sufficient for predictions."""
    for joint in fit["joints"]:
        joint["estimate"]["replicates"] = joint["estimate"]["replicates"][:1]
    return fit

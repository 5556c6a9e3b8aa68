"""Rows of tables about friction, currents and torque constants, and how they changed."""

from collections.abc import Iterator
from dataclasses import asdict
from operator import itemgetter

import pandas as pd

from ur5lib.records.friction import TOTAL, Friction, Parameter
from ur5lib.records.prediction import Prediction
from ur5lib.robots.description import Robot
from ur5lib.tidy import Row, by_joint
from ur5lib.tidy.may_be_used import CONSTANT, contradicted, may_be_used


def friction(friction: Friction, arm: Robot) -> Iterator[Row]:
    """Yield torque constants, offsets and friction, by its terms and in total at a load; of a
    torque constant, also the prior one, and the fitted one where that contradicts it.
    """
    loads = {} if friction.load is None else dict(enumerate(friction.load.tolist(), start=1))
    parts = [(row.joint, _parameter(row, friction, arm)) for row in friction.parameters]
    parts += [
        (row.joint, _parameter(row, friction, arm) | {"load": loads[row.joint]})
        for row in friction.totals
    ]
    yield from (row for _, row in sorted(parts, key=itemgetter(0)))


def without_totals(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the table of friction that are of single parameters."""
    return rows[~rows["parameter"].astype(str).str.startswith(TOTAL)]


def torque_constants(friction: Friction, arm: Robot) -> Iterator[Row]:
    """Yield the torque constants of these alone, a row for each joint of motors with currents."""
    for own in friction.parameters:
        row = _parameter(own, friction, arm)
        if row["parameter"] == "torque_constant":
            yield row | {"torque_constant": row["value"]}


def _parameter(row: Parameter, fitted: Friction, arm: Robot) -> Row:
    """Return the row of a parameter, and whether it may be used."""
    (low, high), joint, known = row.interval, row.joint - 1, fitted.known_constants
    name = arm.measured.parameter(row.name)
    found = asdict(row) | {"parameter": name, "low": low, "high": high}
    if row.name == CONSTANT and known is not None:
        found |= {"known": known.value[joint], "known_std": known.std_error[joint]}
        found |= {"contradicted": contradicted(fitted, row.joint)}
    return found | may_be_used(row, fitted, arm)._asdict()


def cross_validation(friction: Friction) -> Iterator[Row]:
    """Yield the RMSE of a fit to one recording, tested on another."""
    names, tested = friction.from_, friction.cross_validation
    for fitted_on, errors in zip(names, tested, strict=True):
        for tested_on, rmse in zip(names, errors, strict=True):
            yield from by_joint({"rmse_lowpassed": rmse}, fitted_on=fitted_on, tested_on=tested_on)


def current_rmse(currents: Prediction) -> Iterator[Row]:
    """Yield the errors of each model's prediction of a recording's currents."""
    for model, scores in currents.scores.items():
        zero = scores.zero_rmse_lowpassed
        columns = vars(scores) | {"coverage95": scores.coverage, "zero_rmse_lowpassed": zero}
        yield from by_joint(columns, model=model, fitted=currents.fitted)


def payload(currents: Prediction) -> Iterator[Row]:
    """Yield the undeclared payload on the flange; none at rest."""
    if (load := currents.load) is not None:
        low, high = load.interval
        row = asdict(load) | {"low": low, "high": high}
        for name in ("center_of_mass", "center_of_mass_std"):
            values = zip("xyz", getattr(load, name), strict=True)
            row |= {f"{name}_{axis}": value for axis, value in values}
        yield row

"""Torque constants: those of the controller's targets, and the table of the fitted ones."""

import numpy as np

from tests.made_records import motion_of, signals_of
from tests.made_tables import record, table
from ur5lib.identification.current_samples import controllers_ratio
from ur5lib.judging.may_be_used import friction_rows, torque_constants
from ur5lib.records.codes import Found
from ur5lib.records.fits import FrictionRow, TorqueConstant
from ur5lib.records.friction import Friction
from ur5lib.records.quality import Contradictions, Finding
from ur5lib.robots.description import Robot


def test_no_constant_is_taken_from_a_target_that_is_none() -> None:
    time, still = np.arange(9) * 0.008, np.zeros((9, 6))
    targets = {"target_moment": still + 20.0, "target_current": still + 2.0}
    signals, motion = signals_of(time, still, **targets), motion_of(time, still, still)
    odd = Finding("robot", Found.ODD_TARGET, "warning", 1, "it is odd", joints=(2,))
    contradictions = Contradictions(findings=[odd])
    ratio = controllers_ratio(signals, motion, contradictions.odd_targets())
    assert np.isnan(ratio).tolist() == [False, True, False, False, False, False]
    np.testing.assert_allclose(ratio[0], 10.0)


def test_fitted_constants_have_a_table_of_their_own(ur5: Robot) -> None:
    """Those of the table of friction, a row for each joint."""
    rows = [("torque_constant", 10.7), ("coulomb", 6.0)]
    given = {"std_error": 0.1, "interval": [10.5, 10.9]}
    values = [given | {"joint": 2, "name": name, "value": v} for name, v in rows]
    fitted = record(Friction, {"parameters": values})
    own = table(TorqueConstant, {"ur5": torque_constants(fitted, ur5)})
    all_rows = table(FrictionRow, {"ur5": friction_rows(fitted, ur5)})
    assert own[["robot", "joint", "torque_constant"]].to_numpy().tolist() == [["ur5", 2, 10.7]]
    among = all_rows[all_rows["parameter"] == "torque_constant"]
    columns = ["std_error", "low", "high"]
    assert own[columns].to_numpy().tolist() == among[columns].to_numpy().tolist()

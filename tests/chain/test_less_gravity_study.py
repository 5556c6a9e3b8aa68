"""A study of torques less gravity fits what one of the same motion's currents does."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ur5lib
from tests.in_memory import FREE
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import gravity_torque
from ur5lib.tables import channel, named

COMPARED = ("torque_constant", "coulomb", "viscous")


def less_gravity(path: Path) -> pd.DataFrame:
    """The log of a UR with `effort` as its ROS 2 driver publishes it since 2026: torques by the
    controller's constants, less the gravity of the controller's model.
    """
    table, arm = pd.read_csv(path), load_robot(robot_path("ur5e"))
    torque = channel(table, "actual_current") * np.array(arm.maker_torque_constants())
    effort = torque - gravity_torque(arm, arm.chosen_model, channel(table, "actual_q"))
    kept = [c for c in table if c.startswith(("timestamp", "actual_q_", "actual_qd_"))]
    return table[kept].assign(**named(effort, "effort"))


@pytest.fixture(scope="module")
def fitted(folder: Path) -> ur5lib.Model:
    logs = {name.removesuffix(".csv"): less_gravity(folder / name) for name in FREE}
    runs = ur5lib.read(logs, "ur5e")
    told = runs.account.query("confidence != 'evidence'")["taken_for"]
    assert told.str.startswith("actual_torque_less_gravity").any()
    return ur5lib.fit(runs)


@pytest.mark.slow
def test_constants_and_friction_are_within_their_intervals(
    model: ur5lib.Model, fitted: ur5lib.Model
) -> None:
    keys = ["joint", "parameter"]
    by_current, by_torque = (
        own.table("friction").query("determined == 'yes'").set_index(keys)
        for own in (model, fitted)
    )
    both = by_current.merge(
        by_torque, left_index=True, right_index=True, suffixes=("", "_less"), validate="1:1"
    )
    both = both[both.index.get_level_values("parameter").isin(COMPARED)]
    assert {*both.index.get_level_values("joint")} == {1, 2, 3, 4, 5, 6}
    assert len(both) == len(by_current[by_current.index.isin(COMPARED, level="parameter")])
    for one, other in (("", "_less"), ("_less", "")):
        inside = both[f"value{one}"].between(both[f"low{other}"], both[f"high{other}"])
        assert inside.all(), both[~inside]


@pytest.mark.slow
def test_forces_are_the_same(folder: Path, model: ur5lib.Model, fitted: ur5lib.Model) -> None:
    run = ur5lib.read(less_gravity(folder / "pushed.csv"), "ur5e", role="contact")
    forces = [one.estimate(run)[["Fmap_Fx", "Fmap_Fy", "Fmap_Fz"]] for one in (model, fitted)]
    apart = (forces[0] - forces[1]).abs().max()
    assert (apart < 0.1 * forces[0].abs().max()).all(), apart

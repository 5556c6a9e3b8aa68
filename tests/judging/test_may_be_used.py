"""Which constants and friction may be used, by made-up fits, and why not."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.current_study import noisy, prior, smooth
from tests.made_tables import record, table
from ur5lib.judging.may_be_used import MayBeUsed, friction_rows, may_be_used, torque_constants
from ur5lib.records.fits import FrictionRow, TorqueConstant
from ur5lib.records.friction import Friction, Parameter
from ur5lib.robots.description import Robot
from ur5lib.steps.fit_friction import fitted_friction

USED, MOSTLY_PRIOR, SOME_PRIOR = MayBeUsed("yes", ""), 0.9, 0.1
KNOWN = {"value": [10.0], "std_error": [0.5]}


def parameter(name: str = "torque_constant", **given: Any) -> Parameter:
    """One of joint 1 that the data determine."""
    own = {"joint": 1, "name": name, "value": 10.2, "determined": True} | given
    made: Parameter = record(Parameter, own)
    return made


def fit(*codes: str, **given: Any) -> Friction:
    """The fit of one joint with remarks of these codes."""
    joint = {"remarks": [{"code": code, "text": code} for code in codes]}
    joint |= {"estimate": {"coefficients": [0.1]}, "alone": given.pop("alone", None)}
    whole = {"from": ["one"], "fit": {"joints": [joint]}, "known_constants": KNOWN} | given
    made: Friction = record(Friction, whole)
    return made


OPEN = {"determined": False, "prior_share": SOME_PRIOR}
OF_OTHERS = {"determined": False, "prior_share": MOSTLY_PRIOR}
STOPPED = {"stopped": {"code": "contradicting constants", "text": "wrong"}}
OBSTACLES: list[tuple[Friction, dict[str, Any], str]] = [  # the worst first
    (fit(**STOPPED), {}, "stopped"),
    (fit("unlikely constant"), {}, "unlikely"),
    (fit(alone=[0.05]), {}, "contradicted"),
    (fit("unproven fit"), {}, "unproven"),
    (fit(), OF_OTHERS, "prior_only"),
    (fit(), OPEN, "undetermined"),
]


@pytest.mark.parametrize(("fitted", "given", "reason"), OBSTACLES)
def test_a_constant_may_not_be_used(
    ur5: Robot, fitted: Friction, given: dict[str, Any], reason: str
) -> None:
    assert may_be_used(parameter(**given), fitted, ur5) == ("no", reason)


def test_the_worst_is_named_first(ur5: Robot) -> None:
    every = fit("one path", "unproven fit", "unlikely constant", alone=[0.05], **STOPPED)
    assert may_be_used(parameter(value=20.0, **OPEN), every, ur5).reason == "stopped"
    others = fit("one path", "unproven fit", alone=[0.05])
    assert may_be_used(parameter(value=20.0, **OPEN), others, ur5).reason == "contradicted"


def test_a_constant_is_used_with_its_doubt(ur5: Robot) -> None:
    """Beyond 1.96 standard deviations of what is known, it is far; else a single path is named."""
    assert may_be_used(parameter(), fit("few paths"), ur5) == USED
    assert may_be_used(parameter(), fit("one path"), ur5) == ("yes", "one_path")
    for value, doubt in ((10.97, "one_path"), (10.99, "far"), (9.01, "far")):
        found = may_be_used(parameter(value=value), fit("one path"), ur5)
        assert found == ("yes", doubt)
    assert may_be_used(parameter(value=99.0), fit(known_constants=None), ur5) == USED


@pytest.mark.parametrize(
    ("half", "reason"), [(0.3, ""), (0.1, "excludes"), (5.0, ""), (5.2, "imprecise")]
)
def test_a_constant_is_copied_where_its_interval_holds_the_known_one_and_is_narrow(
    ur5: Robot, half: float, reason: str
) -> None:
    found = may_be_used(parameter(interval=[10.2 - half, 10.2 + half]), fit(), ur5)
    assert found == ("yes", reason)
    assert found.state == ("usable" if reason else "good")


def test_nothing_of_a_fit_that_was_touched_is_used(ur5: Robot) -> None:
    for name in ("torque_constant", "coulomb", "total_0.1"):
        found = may_be_used(parameter(name), fit("one path"), ur5, is_touched=True)
        assert (found, found.state) == (("no", "touched"), "do not use")
    assert may_be_used(parameter(), fit(**STOPPED), ur5, is_touched=True).reason == "stopped"


@pytest.mark.parametrize("name", ["coulomb", "offset", "total_0.1"])
def test_friction_is_judged_without_what_concerns_constants_alone(ur5: Robot, name: str) -> None:
    of_fitted = ur5.model_copy(update={"links": "fitted"})
    assert may_be_used(parameter(name, value=99.0), fit(alone=[0.05]), of_fitted) == USED
    for fitted, given, reason in OBSTACLES:
        if reason != "contradicted":
            assert may_be_used(parameter(name, **given), fitted, ur5) == ("no", reason)
    assert may_be_used(parameter(name), fit("one path"), ur5) == ("yes", "one_path")


def test_friction_has_the_doubts_of_its_constant_and_of_its_velocity(ur5: Robot) -> None:
    """It is a current times the constant; a sum of terms is tested up to the fastest sample."""
    sure, far = parameter(), parameter(value=20.0)
    for constant, reason in ((sure, ""), (far, "constant"), (replace(far, joint=2), "")):
        fitted = replace(fit(), parameters=[constant], fastest=np.array([0.5, 0.5]))
        assert may_be_used(parameter("coulomb"), fitted, ur5) == ("yes", reason)
        assert may_be_used(parameter("total_0.5"), fitted, ur5) == ("yes", reason)
        assert may_be_used(parameter("total_1"), fitted, ur5) == ("yes", "extrapolated")


def test_friction_of_a_joint_without_motion_is_not_used(ur5: Robot) -> None:
    """Nor that of an arm fitted at rest alone. Without any recording, it is other arms'."""
    own = parameter("coulomb", **OF_OTHERS)
    assert may_be_used(own, fit("no motion"), ur5) == ("no", "no_motion")
    assert may_be_used(own, fit(**{"from": []}, at_rest=["still"]), ur5) == ("no", "no_motion")
    assert may_be_used(own, fit(**{"from": []}), ur5) == ("no", "prior_only")
    constant = parameter(**OF_OTHERS)
    assert may_be_used(constant, fit("no motion"), ur5) == ("no", "prior_only")


@pytest.mark.parametrize("links", ["unknown", "fitted"])
def test_constants_beside_links_that_are_not_described_are_relative(ur5: Robot, links: str) -> None:
    """The links are in proportion to the measured efforts, so that these determine no constant."""
    arm = ur5.model_copy(update={"links": links})
    assert may_be_used(parameter(), fit("one path"), arm) == ("no", "unknown_links")
    assert may_be_used(parameter(), fit("unproven fit"), arm) == ("no", "unproven")


def test_the_tables_say_what_may_be_used(ur5: Robot) -> None:
    """Of a fit that no study made; totals stand after the terms of their joint, with their load."""
    rows: list[dict[str, Any]] = [
        {"joint": 1, "name": "torque_constant", "value": 10.0, "determined": True},
        {"joint": 1, "name": "coulomb", "value": 6.0, **OF_OTHERS},
        {"joint": 2, "name": "coulomb", "value": 7.0, "determined": True},
    ]
    total = {"joint": 1, "name": "total_0", "value": 8.0, "determined": True}
    given = {"parameters": rows, "totals": [total], "load": [5.5, None]}
    fitted = record(Friction, {"from": ["one"], **given})
    found = table(FrictionRow, {"ur5": friction_rows(fitted, ur5)})
    columns = ["joint", "parameter", "use", "reason"]
    assert found[columns].to_numpy().tolist() == [
        [1, "torque_constant", "yes", ""],
        [1, "coulomb", "no", "prior_only"],
        [1, "total_0", "yes", ""],
        [2, "coulomb", "yes", ""],
    ]
    assert found["load"].dropna().to_dict() == {2: 5.5}
    constants = table(TorqueConstant, {"ur5": torque_constants(fitted, ur5)})
    assert constants[["joint", "use", "reason"]].to_numpy().tolist() == [[1, "yes", ""]]


def test_a_single_path_and_a_joint_at_rest_are_named(ur5: Robot) -> None:
    """By the remarks that a fit makes."""
    (whole,) = noisy([1])
    still = replace(whole, q=whole.q * [1, 1, 1, 1, 0, 1], qd=whole.qd * [1, 1, 1, 1, 0, 1])
    fitted = fitted_friction([still], prior(), smooth)
    found = table(FrictionRow, {"ur5": friction_rows(fitted, ur5)})
    found = found.set_index(["joint", "parameter"])
    assert tuple(found.loc[(2, "torque_constant"), ["use", "reason"]]) == ("yes", "one_path")
    assert tuple(found.loc[(2, "total_0.1"), ["use", "reason"]]) == ("yes", "one_path")
    assert tuple(found.loc[(5, "coulomb"), ["use", "reason"]]) == ("no", "no_motion")
    assert tuple(found.loc[(5, "torque_constant"), ["use", "reason"]]) == ("no", "prior_only")
    totals = found.index[found["load"].notna()]
    assert {joint for joint, _ in totals} == {1, 2, 3, 4, 6}


@pytest.mark.parametrize(("fitted_on", "reason"), [((1, 2, 3), "unproven"), ((1, 2), "")])
def test_a_fit_that_others_belie_is_named(
    ur5: Robot, fitted_on: tuple[int, ...], reason: str
) -> None:
    """Joint 2 of the third recording has the current of another arm."""
    records = noisy((1, 2, 3))
    other = records[2].current.copy()
    other[:, 1] *= -3
    records[2] = replace(records[2], current=other)
    fitted = fitted_friction([records[seed - 1] for seed in fitted_on], prior(), smooth)
    (own,) = (row for row in fitted.parameters if (row.joint, row.name) == (2, "coulomb"))
    assert may_be_used(own, fitted, ur5).reason == reason

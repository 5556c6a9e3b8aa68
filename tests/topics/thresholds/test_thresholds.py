"""Torques that samples without contact seldom exceed: their share, by property, and their files."""

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ur5lib.errors import InputError
from ur5lib.records.currents import Currents
from ur5lib.records.verdicts import Verdict
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.study.model import Settings
from ur5lib.tables import write_rows
from ur5lib.topics.thresholds.exports import FORMATS
from ur5lib.topics.thresholds.torque_thresholds import (
    ACCELERATING_SHARE,
    LEVELS,
    Free,
    left_out,
    quantiles,
    speed_classes,
    speed_edges,
    thresholds_of,
)

SAMPLES = 6000
RATES = pytest.mark.parametrize("rate", LEVELS.values())


def free(seed: int, scale: float = 1.0, samples: int = SAMPLES) -> Free:
    """Torques with heavy tails that grow with the speed, some unknown."""
    draw = np.random.default_rng(seed)
    speed = np.abs(draw.normal(0, 0.5, (samples, 6))) * (draw.random((samples, 6)) > 0.3)
    torque = np.abs(draw.standard_t(3, (samples, 6))) * scale * (1 + speed) * np.arange(1, 7)
    torque[draw.random(torque.shape) < 0.02] = np.nan
    return Free(torque, speed, np.abs(draw.normal(0, 1, speed.shape)))


class MadeStudy:
    """Results of two recordings without contact, one pushed and one of another arm."""

    def __init__(self, folder: Path, samples: int = SAMPLES, robot: str = "ur5") -> None:
        self.folder, self.robot, self.samples = folder, robot, samples
        roles = {"one": "fit", "two": "validate", "pushed": "contact"}
        arms = dict.fromkeys(roles, robot) | {"other": "ur10"}
        self.parts = {name: free(k, 1.0 + 9 * (k > 1), samples) for k, name in enumerate(arms)}
        self.entries = [
            SimpleNamespace(name=name, role=roles.get(name, "fit"), at_rest=False,
                            arm=SimpleNamespace(known_as=arm))
            for name, arm in arms.items()
        ]  # fmt: skip

    def configuration(self) -> Any:
        return SimpleNamespace(recordings=self.entries, settings=Settings())

    def record(self, kind: type, name: str) -> Any:
        part = self.parts[name]
        if kind is Currents:
            return SimpleNamespace(external_torque=-part.torque)
        return SimpleNamespace(qd=-part.speed, qdd=part.acceleration)

    def arm(self, name: str) -> Any:
        return load_robot(robot_path(name))

    def judged(self, state: str) -> "MadeStudy":
        write_rows(
            Verdict, [Verdict(question="force", state=state)], self.folder / "tables/verdicts.csv"
        )
        return self


@RATES
def test_the_stated_share_of_each_class_is_beyond_its_threshold(rate: float) -> None:
    """Exactly: the next smaller torque of a sample would be exceeded by more."""
    own = free(0, samples=20 * SAMPLES)
    classes = speed_classes(own, speed_edges(own))
    np.testing.assert_array_equal(sum(classes), np.ones_like(own.torque))
    limits = quantiles(own.torque, classes, rate)
    for one, limit in zip(classes, limits, strict=True):
        count = (one & np.isfinite(own.torque)).sum(axis=0)
        beyond = (one & (own.torque > limit)).sum(axis=0)
        assert (count * rate >= 1).all()
        np.testing.assert_array_equal(beyond, np.floor(rate * count + 1e-9))


def test_a_class_with_few_samples_has_the_threshold_of_all() -> None:
    own = free(0)
    few = np.zeros_like(own.torque, bool)
    few[:50] = True
    every = quantiles(own.torque, [~np.zeros_like(few)], 0.01)
    np.testing.assert_array_equal(quantiles(own.torque, [few], 0.01), every)


@RATES
def test_recordings_left_out_have_the_share_if_they_are_alike_and_more_if_not(rate: float) -> None:
    alike = [free(k) for k in range(4)]
    edges = speed_edges(alike[0])
    mean, worst = left_out(alike, edges, rate)
    assert mean == pytest.approx(rate, rel=0.2)
    assert mean <= worst < 3 * rate
    assert left_out([*alike, free(9, 3.0)], edges, rate)[1] > 5 * rate
    assert np.isnan(left_out(alike[:1], edges, rate)).all()


def test_the_file_has_the_terms_of_controllers(tmp_path: Path) -> None:
    study = MadeStudy(tmp_path).judged("usable")
    told = json.loads(FORMATS["thresholds"](study, "ur5", "", ""))
    assert told["recordings"] == ["one", "two"]
    assert told["false_alarm_rates"] == LEVELS
    one, two = study.parts["one"], study.parts["two"]
    torque, acceleration = (np.vstack([one[k], two[k]]) for k in (0, 2))
    above = acceleration > told["accelerating_from"]
    largest = np.quantile(acceleration, 0.999, axis=0)
    np.testing.assert_allclose(told["accelerating_from"], ACCELERATING_SHARE * largest)
    for level, rate in LEVELS.items():
        for phase, inside in (("acceleration", above), ("nominal", ~above)):
            limit = told["collision_behavior"][f"{level}_torque_thresholds_{phase}"]
            known = (inside & np.isfinite(torque)).sum()
            beyond = (inside & (torque > limit)).sum()
            if (inside & np.isfinite(torque)).sum(axis=0).min() * rate >= 1:
                assert rate - 6 / known < beyond / known <= rate
        assert rate / 3 < told["left_out"][level]["mean"] < 3 * rate
    samples = sum(row["samples"] for row in told["by_speed"])
    assert samples == np.isfinite(torque).sum()
    assert all(row["lower"] <= row["upper"] for row in told["by_speed"])


def test_urscript_has_the_lower_thresholds(tmp_path: Path) -> None:
    study: Any = MadeStudy(tmp_path).judged("usable")
    script = FORMATS["thresholds.script"](study, "ur5", "", "")
    rows = dict(re.findall(r"local (\w+) = \[(.*)\]", script))
    lower = thresholds_of(study, "ur5").by_speed["lower"]
    for name, limit in zip(("resting", "slow", "fast"), lower, strict=True):
        np.testing.assert_allclose([*map(float, rows[name].split(", "))], limit, atol=6e-4)
    opened = len(re.findall(r"^ *(?:def|while|if) ", script, re.MULTILINE))
    assert opened == len(re.findall(r"^ *end$", script, re.MULTILINE))


@pytest.mark.parametrize(
    ("changes", "call", "message"),
    [
        ({}, {"accept": ""}, "force: do not use"),
        ({}, {"as_in": "one"}, "leave out --as-in"),
        ({"samples": 400}, {"accept": "a lesson"}, "needs 1000; record longer"),
        ({}, {"accept": "a lesson", "robot": "ur3"}, "no external torque of ur3"),
        ({"robot": "kuka-kr300"}, {"form": "thresholds.script", "accept": "a lesson"}, "of URs"),
    ],
)
def test_it_is_refused_where_forces_are_and_where_too_little_is_known(
    changes: dict[str, Any], call: dict[str, str], message: str, tmp_path: Path
) -> None:
    study: Any = MadeStudy(tmp_path, **changes).judged("do not use")
    robot = call.get("robot", study.robot)
    with pytest.raises(InputError, match=message):
        FORMATS[call.get("form", "thresholds")](
            study, robot, call.get("as_in", ""), call.get("accept", "")
        )


def test_a_reason_overrules_the_verdict_and_is_stated(tmp_path: Path) -> None:
    study: Any = MadeStudy(tmp_path).judged("do not use")
    told = json.loads(FORMATS["thresholds"](study, "ur5", "", "a lesson"))
    assert told["accepted"]["reason"] == "a lesson"
    assert "a lesson" in FORMATS["thresholds.script"](study, "ur5", "", "a lesson").splitlines()[0]
    with pytest.raises(InputError, match="--results"):
        FORMATS["thresholds"](None, "ur5", "", "")

"""The benchmark's tables of simulated arms, touched links and predicted currents, by identity."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from benchmarks.current_prediction import Known, Own, pair_rows
from benchmarks.estimators.ours import OURS
from benchmarks.harness.detection import detection_tables
from benchmarks.harness.links import link_table
from benchmarks.harness.prediction import FLOOR, prediction_findings, prediction_table
from benchmarks.harness.pushes import PLACES
from benchmarks.harness.simulated import simulated_table
from benchmarks.simulated_contacts import force_at
from ur5lib.identification.samples import Record
from ur5lib.robots.description import Robot
from ur5lib.tables import write_csv

PERIOD, COUNT = 0.008, 1000  # s, samples


def seed_row(seed: int, estimator: str, error: float) -> dict[str, Any]:
    """Return a seed whose estimator errs by `error` [N] everywhere, in 10 samples each place."""
    places = {"flange": 10, "tool": 10, "elbow": 10}
    squares = {f"{place}_square": count * error**2 for place, count in places.items()}
    samples = {f"{place}_samples": count for place, count in places.items()}
    about = {"seed": seed, "estimator": estimator, "causal": "no", "latency_s": np.nan}
    return about | squares | samples | {"free": 1.0}


def test_seeds_are_pooled_by_their_samples() -> None:
    table = pd.DataFrame(
        [seed_row(k, name, error) for k in (0, 1) for name, error in ((OURS, 3.0), ("other", 4.0))]
    )
    ours, other = simulated_table(table).splitlines()[2:]
    assert ours.startswith(f"| {OURS} | no |  | 3.0 (3.0 to 3.0) |  | 3.0")
    assert other.startswith("| other | no |  | 4.0 (4.0 to 4.0) | +1.0 (1.0 to 1.0) |")


def test_an_estimator_that_lacks_a_seed_is_left_out() -> None:
    rows = [seed_row(0, OURS, 3.0), seed_row(1, OURS, 3.0), seed_row(1, "other", 4.0)]
    assert "other" not in simulated_table(pd.DataFrame(rows))


def test_a_push_acts_at_its_place_and_time() -> None:
    link, point = PLACES["elbow"]
    push = {"link": link, "point": point, "start_s": 1.0, "seconds": 2.0, "force": [0, 0, 8.0]}
    time = np.array([0.5, 1.5, 2.0, 3.5])
    assert force_at("elbow", time, [push])[:, 2] == pytest.approx([0, 4, 8, 0])
    assert not force_at("flange", time, [push]).any()


def test_contacts_are_counted_by_force_and_link() -> None:
    unsure = {"stated": 0.6, "right": False, "named": False, "likely": 4, "held": True}
    sure = {"stated": 1.0, "right": True, "named": True, "likely": 1, "held": True}
    rows = [{"link": 6, "force": 7.0} | unsure, {"link": 6, "force": 30.0} | sure]
    lines = link_table(pd.DataFrame(rows)).splitlines()
    assert lines[2] == "| 5 to 10 N | 1 | 0 | 0 | 1 | 60% | 0% | 4.0 | 100% |"
    assert lines[-2] == "| on link 6 | 2 | 1 | 0 | 1 | 80% | 50% | 2.5 | 100% |"
    assert lines[-1] == "| all | 2 | 1 | 0 | 1 | 80% | 50% | 2.5 | 100% |"


def test_contacts_found_are_those_of_the_study(tmp_path: Path) -> None:
    """Without a sensor, alarms count on recordings that nothing touches and no fit has seen."""
    roles = {"pushed": "contact", "free": "validate", "fitted": "fit", "touched": "contact"}
    study = {"recordings": [{"name": name, "role": role} for name, role in roles.items()]}
    (tmp_path / "configuration.yaml").write_text(yaml.safe_dump(study))
    rows = [
        {"recording": name, "estimate": estimate, "threshold": 5.0, "alarms_per_min": 1.5}
        | ({"force_class_n": 3.0, "contacts": 4, "found": 2} if name == "pushed" else {})
        for name in roles
        for estimate in ("Fmap", "F", "F*", "Fu")
    ]
    counted = ["false_alarms_per_min", "extra_alarms", "free_time_in_alarm", "median_delay_s"]
    causal = ["causal_found", "causal_delay_s"]
    table = pd.DataFrame(rows).reindex(columns=[*rows[0], *counted, *causal])
    (tmp_path / "tables").mkdir()
    write_csv(table, tmp_path / "tables" / "detection.csv")
    found, false = detection_tables([tmp_path]).split("\n\n")
    assert len(found.splitlines()) == 2 + 4
    assert "| pushed | F̂* | 5.0 | 2 of 4 |" in found
    (alarms,) = false.splitlines()[2:]
    assert alarms.startswith("| free | validate | 1.5 | 1.5 | 1.5 | 1.5 |")


def predictions() -> pd.DataFrame:
    """Return errors of 1 A for 3 s and of 3 A for 1 s; a rival errs by 1.5 A."""
    rows = [
        {"arm": "arm", "joint": 1, "during": during, "model": model, "path": 1}
        | {"seconds": seconds, "square": square}
        for during in ("motion", "rest")
        for model, pairs in {"ours": ((3, 1.0), (1, 9.0)), "least squares": ((4, 2.25),)}.items()
        for seconds, square in pairs
    ]
    return pd.DataFrame(rows)


def test_recordings_count_by_their_time() -> None:
    assert prediction_table(predictions()).splitlines()[2].startswith("| arm | 1 | 1.500 | 1.732 |")


def test_the_page_names_the_joints_on_which_ours_is_worse() -> None:
    (sentence,) = prediction_findings(predictions())
    assert "115% of least squares (higher on joint 1)" in sentence
    assert sentence.endswith("No path was repeated.")


def test_the_floor_is_half_the_square_of_what_repeats_differ_by(ur5: Robot) -> None:
    phase = np.linspace(0, 6, COUNT)[:, None] + np.arange(6)
    q, qd = np.sin(phase), np.cos(phase) * 6 / (COUNT * PERIOD)
    zeros, segment = np.zeros((COUNT, 6)), np.zeros(COUNT, int)
    record = Record("first", PERIOD, segment, q, qd, zeros, zeros)
    first = Own(record, zeros, zeros, zeros, np.ones(6), fitted=True)
    second = replace(first, record=replace(record, name="second", current=zeros + 0.2))
    arm = Known("arm", Path(), ur5, lambda values, _: values, [first, second], np.zeros(2, int))
    rows = pd.DataFrame(pair_rows(arm, first, second))
    assert len(rows[rows["model"] == FLOOR]) == 6
    assert rows[rows["model"] == FLOOR]["square"].to_numpy() == pytest.approx(0.02)
    assert rows[rows["model"] == "ours"]["square"].to_numpy() == pytest.approx(0.04)

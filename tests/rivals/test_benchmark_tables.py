"""The benchmark's tables of simulated arms and of contacts found, by identity."""

from collections.abc import Collection, Iterator
from contextlib import nullcontext
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from benchmarks import simulated_contacts
from benchmarks.harness.cells import DATA, cell
from benchmarks.harness.pushes import PLACES
from benchmarks.harness.sections import detection_tables
from benchmarks.harness.simulated import better_than_ours, refused_on_some, simulated_table
from benchmarks.simulated_contacts import force_at
from ur5lib.tables import write_csv
from ur5rivals.estimators.ours import OURS
from ur5rivals.tuning import MAX_LATENCY


def test_the_rule_for_latency_includes_the_live_estimate() -> None:
    latency = cell(DATA / "leaderboard.csv", "F̂ᵐᵃᵖ, live", "latency")
    assert float(latency.removesuffix(" ms")) <= 1000 * MAX_LATENCY


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
    assert ours.startswith(f"| {OURS} | no |  | 3.0 (3.0 to 3.0) | 3.0")
    assert other.startswith("| other | no |  | 4.0 (4.0 to 4.0) | 4.0 (4.0 to 4.0) |")


def test_who_is_better_than_ours_is_said() -> None:
    errors = {OURS: 3.0, "better": 2.0, "worse": 4.0}
    rows = [seed_row(seed, *own) for seed in (0, 1) for own in errors.items()]
    flange, tool = better_than_ours(pd.DataFrame(rows))
    assert flange == "at the flange: better by −1.0 (−1.0 to −1.0) N"
    assert tool.startswith("at the tool: better")


def test_who_was_refused_on_some_seeds_is_said() -> None:
    lacking = {(1, "picky"), (0, "never"), (1, "never")}
    rows = [
        seed_row(*own, error=np.nan if own in lacking else 3.0)
        for own in product((0, 1), (OURS, "picky", "never"))
    ]
    table = pd.DataFrame(rows)
    assert refused_on_some(table) == ["picky on 1 of 2"]
    assert "picky" not in simulated_table(table)


@pytest.mark.parametrize("of_seed_0", [[], [{"seed": 0, "estimator": "other"}]])
def test_an_estimator_without_figures_for_a_seed_is_left_out(of_seed_0: list[dict]) -> None:
    rows = [seed_row(0, OURS, 3.0), seed_row(1, OURS, 3.0), seed_row(1, "other", 4.0)]
    assert "other" not in simulated_table(pd.DataFrame([*rows, *of_seed_0]))


def simulate(monkeypatch: pytest.MonkeyPatch, *arguments: str, stop: int = -1) -> list[int]:
    """Return the seeds that a quick run computes here, until it is interrupted at one."""
    computed: list[int] = []

    def rows(seed: int, _: int, __: float, names: Collection[str]) -> Iterator[dict[str, Any]]:
        if seed == stop:
            raise KeyboardInterrupt
        computed.append(seed)
        error = np.random.default_rng(seed).uniform(1, 5)
        yield from (seed_row(seed, name, error / 3) for name in names)

    monkeypatch.setattr(simulated_contacts, "seed_rows", rows)
    monkeypatch.setattr("sys.argv", ["simulated_contacts", *arguments, "--quick"])
    with pytest.raises(KeyboardInterrupt) if stop >= 0 else nullcontext():
        simulated_contacts.main()
    return computed


def test_seeds_go_on_where_a_run_was_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tables = []
    for name, stops in (("whole", []), ("stopped", [2, 5])):
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        computed = [seed for stop in stops for seed in simulate(monkeypatch, "12", stop=stop)]
        assert computed + simulate(monkeypatch, "12") == [*range(12)]
        tables.append(Path("results/simulated_contacts_quick.csv").read_bytes())
    assert tables[0] == tables[1]
    assert simulate(monkeypatch, "12") == []


def test_two_runs_may_share_the_seeds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert simulate(monkeypatch, "6", "--first", "3") == [3, 4, 5]
    assert simulate(monkeypatch, "3") == [0, 1, 2]
    table = pd.read_csv("results/simulated_contacts_quick.csv")
    assert table["seed"].drop_duplicates().tolist() == [*range(6)]


def test_seeds_that_lack_an_estimator_are_computed_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    simulate(monkeypatch, "2")
    path = Path("results/simulated_contacts_quick/1.csv")
    write_csv(pd.read_csv(path).iloc[1:], path)
    assert simulate(monkeypatch, "2") == [1]


def test_a_push_acts_at_its_place_and_time() -> None:
    link, point = PLACES["elbow"]
    push = {"link": link, "point": point, "start_s": 1.0, "seconds": 2.0, "force": [0, 0, 8.0]}
    time = np.array([0.5, 1.5, 2.0, 3.5])
    assert force_at("elbow", time, [push])[:, 2] == pytest.approx([0, 4, 8, 0])
    assert not force_at("flange", time, [push]).any()


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
    table = pd.DataFrame(rows).reindex(columns=[*rows[0], *counted, "merged"])
    (tmp_path / "tables").mkdir()
    write_csv(table, tmp_path / "tables" / "detection.csv")
    tables = detection_tables([tmp_path])
    assert len(tables["found"].splitlines()) == 2 + 2
    assert "| pushed | F̂ᵘ | 5.0 | 2 of 4 |" in tables["found"]
    (alarms,) = tables["alarms"].splitlines()[2:]
    assert alarms == "| free | 1.5 | 1.5 |"

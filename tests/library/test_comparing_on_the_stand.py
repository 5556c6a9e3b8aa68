"""`ur5 compare` on simulated studies: what other recordings change, and what a worn joint does."""

from collections.abc import Callable
from functools import cache
from itertools import combinations
from pathlib import Path

import pytest

from benchmarks.stand_seeds import MOTION, fitted_map, rotors, taken
from tests.made_tables import empty, table
from ur5lib.commands.compare import TOPICS, Comparison, compare
from ur5lib.robots.description import load_robot, robot_path

pytestmark = pytest.mark.slow

PATHS, SECONDS = 5, 12.0
SEEDS = 2
Study = Callable[..., Path]


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """The results of a study of one arm by the seed of paths and noise, and joint 3's friction."""

    @cache
    def build(seed: int, coulomb_3: float = 1.0) -> Path:
        folder = tmp_path_factory.mktemp(f"study_{seed}")
        recordings = [
            taken(plan(path, seed, coulomb_3), folder / f"raw_{path}") for path in range(PATHS)
        ]
        robot = load_robot(robot_path("ur5"))
        arm = {"arm": {"ur5": robot}, "friction": {"ur5": fitted_map(recordings)}}
        known = {
            "friction": table("friction", **arm),
            "rotor_inertia": table("rotor_inertia", rotors={"ur5": rotors(recordings)}),
        }
        (folder / "tables").mkdir()
        for name in (*known, "parameters", "payload", "current_rmse", "force_mae", "quality"):
            rows = known.get(name, empty(name))
            rows.to_csv(folder / "tables" / f"{name}.csv", index=False)
        return folder

    return build


def plan(path: int, seed: int, coulomb_3: float) -> dict[str, object]:
    trajectory = MOTION | {"draw": 10 * seed + path, "period_s": SECONDS}
    factors = [1.0, 1.0, coulomb_3, 1.0, 1.0, 1.0]
    noise = {"seed": 100 * seed + path, "seconds": SECONDS}
    return {"trajectory": trajectory, "coulomb_factor": factors} | noise


def of_friction(found: list[Comparison]) -> list[Comparison]:
    return [one for one in found if one.topic == "friction"]


def test_a_study_does_not_differ_from_itself(study: Study) -> None:
    found = compare(study(1), study(1))
    assert {one.topic for one in found} == {"friction", "model"} < set(TOPICS)
    assert not any(one.differs or one.changed for one in found)


def test_other_recordings_of_the_same_arm_have_not_changed(study: Study) -> None:
    """Other paths, other noise: at most one in twenty differs; five paths make intervals wide."""
    pairs = combinations(range(1, SEEDS + 1), 2)
    found = [compare(study(one), study(other)) for one, other in pairs]
    each = [one for pair in found for one in of_friction(pair)]
    assert len(each) >= 24
    assert sum(one.differs for one in each) <= 0.05 * len(each) + 2
    assert not any(one.changed for pair in found for one in pair)


def test_more_coulomb_friction_on_one_joint_is_named_and_nothing_else(study: Study) -> None:
    """By half, which is more than days differ, also among this many numbers."""
    changed = [one.name for one in compare(study(1), study(SEEDS + 1, 1.5)) if one.changed]
    assert changed == ["ur5, joint 3, coulomb"]

"""`ur5 compare` on simulated studies: what other recordings change, and what a worn joint does."""

from pathlib import Path

import pytest

from benchmarks.harness.stand import MOTION, fitted_map, rotors, taken
from tests.made_tables import empty, table
from ur5lib.judging.may_be_used import friction_rows
from ur5lib.records.fits import FrictionRow, RotorRow
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.steps.make_tables import rotor_rows
from ur5lib.topics.compare.comparison import compare

pytestmark = [pytest.mark.slow, pytest.mark.thorough]  # ten simulated recordings

PATHS, SECONDS = 5, 12.0


def study(folder: Path, seed: int, coulomb_3: float = 1.0) -> Path:
    """The results of a study of one arm by the seed of paths and noise, and joint 3's friction."""
    recordings = [
        taken(plan(path, seed, coulomb_3), folder / f"raw_{path}") for path in range(PATHS)
    ]
    robot = load_robot(robot_path("ur5"))
    known = {
        "friction": table(FrictionRow, {"ur5": friction_rows(fitted_map(recordings), robot)}),
        "rotor_inertia": table(RotorRow, {"ur5": rotor_rows(rotors(recordings))}),
    }
    (folder / "tables").mkdir(parents=True)
    for name in (
        *known,
        "parameters",
        "payload",
        "current_rmse",
        "force_mae",
        "quality",
        "recordings",
    ):
        rows = known.get(name, empty(name))
        rows.to_csv(folder / "tables" / f"{name}.csv", index=False)
    return folder


def plan(path: int, seed: int, coulomb_3: float) -> dict[str, object]:
    trajectory = MOTION | {"draw": 10 * seed + path, "period_s": SECONDS}
    factors = [1.0, 1.0, coulomb_3, 1.0, 1.0, 1.0]
    noise = {"seed": 100 * seed + path, "seconds": SECONDS}
    return {"trajectory": trajectory, "coulomb_factor": factors} | noise


def test_more_coulomb_friction_on_one_joint_is_named_and_nothing_else(tmp_path: Path) -> None:
    """By half, which is more than days differ, found on other paths and with other noise.

    Of the other numbers, at most one in twenty differs; five paths make intervals wide.
    """
    found = compare(study(tmp_path / "one", 1), study(tmp_path / "other", 2, 1.5))
    assert [one.name for one in found if one.changed] == ["ur5, joint 3, coulomb"]
    others = [one for one in found if one.topic == "friction" and not one.changed]
    assert len(others) >= 23
    assert sum(one.differs for one in others) <= 0.05 * len(others) + 2

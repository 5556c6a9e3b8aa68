"""Which file follows another: found where posture and order show it, and never else."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.entries import in_words
from tests.stored_files import made_up_channels, write_npz
from ur5lib.importing.after import Ends, links
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.importing.in_memory import read
from ur5lib.study.selection import Selection
from ur5lib.timeseries.arrays import Array

NOISE = 1e-5  # rad, of a posture at rest
Session = list[tuple[Array, Array]]  # first and last posture of each file
NO_STAMP = np.nan


@pytest.fixture
def random() -> np.random.Generator:
    return np.random.default_rng(1)


def session(random: np.random.Generator, count: int, size: float, joints: int = 6) -> Session:
    """Files of which each begins where the one before ended; size: of what is between [rad]."""
    postures = random.normal(0, size, (count + 1, joints))
    noise = random.normal(0, NOISE / 10, (count, 2, joints))
    return [(a + n[0], b + n[1]) for (a, b), n in zip(pairwise(postures), noise, strict=True)]


def found(files: Session, paths: list[str] | None = None) -> dict[str, str]:
    """What each file follows; their paths are counted from 1."""
    named = paths or [f"raw/run-{k}" for k in range(1, len(files) + 1)]
    ends = {p: Ends(p, *own, NO_STAMP, NO_STAMP) for p, own in zip(named, files, strict=True)}
    return {name: link.before for name, link in links(ends).items()}


def chained(names: list[str]) -> dict[str, str]:
    return {later: before for before, later in pairwise(names)}


@pytest.mark.parametrize("count", [2, 3, 12])
@pytest.mark.parametrize("joints", [4, 6, 7])
def test_files_that_go_on_in_other_postures_follow(
    random: np.random.Generator, count: int, joints: int
) -> None:
    files = session(random, count, 1.0, joints)
    assert found(files) == chained([f"raw/run-{k}" for k in range(1, count + 1)])


def test_numbers_must_follow_and_the_last_that_does_counts(random: np.random.Generator) -> None:
    files = session(random, 4, 1.0)
    names = [f"{day}/arm7_{k:03d}_v2" for day, k in (("d1", 9), ("d1", 10), ("d2", 9), ("d2", 10))]
    assert found(files, names) == {names[1]: names[0], names[3]: names[2]}
    assert found(files, ["first", "second", "third", "fourth"]) == {}
    assert found(files, [f"run-{2 * k}" for k in range(4)]) == {}
    folders = [f"run{k}/log" for k in range(4)]
    assert found(files, folders) == chained(folders)


def test_an_arm_that_returns_home_shows_nothing(random: np.random.Generator) -> None:
    home = random.normal(0, 1, 6)
    for size in (0.0, NOISE, 2 * NOISE):
        for count in (2, 5, 40):
            postures = home + random.normal(0, size, (count, 2, 6))
            assert found([(a, b) for a, b in postures]) == {}


def test_a_home_that_drifts_shows_nothing(random: np.random.Generator) -> None:
    places = np.cumsum(random.normal(0, NOISE, (60, 6)), axis=0)
    noise = random.normal(0, NOISE / 10, (60, 2, 6))
    assert found([(a + n[0], a + n[1]) for a, n in zip(places, noise, strict=True)]) == {}


def test_a_third_file_that_fits_as_well_leaves_it_open(random: np.random.Generator) -> None:
    first, second = session(random, 2, 1.0)
    assert found([first, second]) == {"raw/run-2": "raw/run-1"}
    assert found([first, second, (random.normal(0, 1, 6), first[1] + NOISE)]) == {}


def test_one_joint_elsewhere_is_another_posture(random: np.random.Generator) -> None:
    first, second = session(random, 2, 1.0)
    assert found([first, (second[0] + 2e-4 * np.eye(6)[3], second[1])]) == {}


def test_where_many_files_rest_near_home_their_places_tell_the_order(
    random: np.random.Generator,
) -> None:
    """As of a KUKA KR300: at home, each file begins by microradians where the one before ended."""
    files = session(random, 40, 2 * NOISE)
    assert found(files) == chained([f"raw/run-{k}" for k in range(1, 41)])
    shuffled = [files[k] for k in random.permutation(40)]
    assert found(shuffled) == {}
    assert found(files[:4]) == {}


def test_absolute_stamps_tell_the_order_and_the_time_between(random: np.random.Generator) -> None:
    files = session(random, 3, 1.0)
    starts = 1.7e9 + np.array([0.0, 100.0, 300.0])
    ends = {
        name: Ends("log", *own, began, began + 60)
        for name, own, began in zip("cab", files, starts, strict=True)
    }
    both = links(ends)
    assert {name: link.before for name, link in both.items()} == chained(["c", "a", "b"])
    assert [both[name].gap for name in "ab"] == [40.0, 140.0]
    assert "140 s before" in both["b"].row().reason


def test_files_of_one_motion_are_imported_and_read_as_a_chain(tmp_path: Path) -> None:
    time, channels = made_up_channels(tmp_path)
    cuts = np.linspace(0, len(time) - 1, 4).astype(int)
    names = [f"run{k}.npz" for k in (1, 2, 3)]
    for name, (start, end) in zip(names, pairwise(cuts), strict=True):
        rows = slice(start, end + 1)
        part = {channel: values[rows] for channel, values in channels.items()}
        write_npz(tmp_path / name, time[rows] - time[start], part)
    files = [tmp_path / name for name in names]
    imported = import_files(files, UserStatement("ur5"))
    assert [one.entry.get("after") for one in imported] == [None, "run1", "run2"]
    assert "run1 ended in the posture in which this begins" in in_words(imported[1].account)
    assert Selection(read(files, "ur5")._study).before("run3") == ["run1", "run2"]

"""Whatever is damaged is refused in words, or read: once here, for an hour each night."""

from pathlib import Path

import pytest

from tests.fuzz import OUTCOMES, Target, fuzz, table, targets
from ur5lib.errors import InputError

HOUR = 3600.0  # s
pytestmark = pytest.mark.slow


def test_each_target_is_tried(tmp_path: Path) -> None:
    several = [one for one in targets(tmp_path) if one.name != "models"]  # which are fitted first
    assert len(several) >= 8
    wrong = [one.try_once(seed=1) for one in several for _ in range(3)]
    assert not any(wrong), "\n".join(wrong)


def test_crashes_and_hangs_are_counted_and_their_files_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tests.fuzz.SECONDS", 1)
    number = iter(range(99))

    def attempt(draw: object, place: Path) -> None:
        (place / "damaged").touch()
        match next(number):
            case 0:
                raise InputError("refused")
            case 1:
                raise KeyError("crash")
            case 2:
                while True:
                    pass

    target = Target("made up", lambda _: attempt, tmp_path)
    said = [target.try_once(seed=1) for _ in range(4)]
    assert [target.counts[one] for one in OUTCOMES] == [1, 1, 1, 1]
    assert [bool(one) for one in said] == [False, True, True, False]
    assert "KeyError: 'crash'" in said[1]
    kept = {path.parent.name for path in tmp_path.rglob("damaged")}
    assert kept == {"1", "2"}
    assert table([target]).splitlines()[1].split() == ["made", "up", "4", "1", "1", "1", "1"]


@pytest.mark.thorough
def test_an_hour_of_damage_crashes_nothing(tmp_path: Path) -> None:
    several = targets(tmp_path)
    wrong = fuzz(several, HOUR, seed=2)
    print(table(several))
    assert not wrong

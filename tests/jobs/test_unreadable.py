"""What a recording that cannot be read leaves in its files, and what others make of it."""

from pathlib import Path

import pytest

from ur5lib.errors import UnreadableError
from ur5lib.jobs.unreadable import MAX_BYTES, marked, readable, reason, unreadable

WHY = 'line 3 of "a.csv" – nothing'


def files(folder: Path, name: str, *names: str) -> list[str]:
    """The paths of a file by recording."""
    return [str(folder / "recordings" / recording / name) for recording in names]


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """Recordings a to d, of which b and d cannot be read."""
    for name in ("quality.json", "motion.parquet"):
        for recording in "abcd":
            (path,) = map(Path, files(tmp_path, name, recording))
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(marked(WHY) if recording in "bd" else "{}")
    return tmp_path


def test_a_mark_says_why_whatever_the_file_is(study: Path) -> None:
    for name in ("quality.json", "motion.parquet"):
        whole, torn = files(study, name, "a", "b")
        assert (reason(whole), reason(torn)) == ("", WHY)
    assert unreadable(study) == {"b": WHY, "d": WHY}
    assert reason(str(study / "nowhere.json")) == ""


@pytest.mark.parametrize("content", [b"", b"PAR1\xff\x00", b'{"unread": 1}', bytes(MAX_BYTES + 1)])
def test_other_files_are_no_marks(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "file").write_bytes(content)
    assert reason(str(tmp_path / "file")) == ""


def test_a_job_of_such_a_recording_stops_with_its_reason(study: Path) -> None:
    (motion,) = files(study, "motion.parquet", "b")
    with pytest.raises(UnreadableError) as stop:
        readable({"arm": str(study / "arm.yaml"), "motion": motion})
    assert str(stop.value) == WHY


def test_a_job_of_several_goes_on_without_it(study: Path) -> None:
    """As if it had never been there; files that are none of recordings stay."""
    names = ("motion.parquet", "quality.json")
    arm: dict[str, str | list[str]] = {"arm": str(study / "arm.yaml"), "parts": []}
    given = arm | {name: files(study, name, *"abcd") for name in names}
    rest = arm | {name: files(study, name, *"ac") for name in names}
    assert readable(given) == (rest, {"b": WHY, "d": WHY})
    assert readable(rest) == (rest, {})


def test_where_none_is_left_a_job_goes_on_as_without_recordings(study: Path) -> None:
    """Before, one broken recording ended a study that had no other to fit on."""
    motion = files(study, "motion.parquet", "b", "d")
    assert readable({"motion": motion}) == ({"motion": []}, {"b": WHY, "d": WHY})

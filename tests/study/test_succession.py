"""Recordings that follow each other: chains, patterns, and what is no succession."""

import random
from pathlib import Path
from typing import Any

import pytest
import yaml

from ur5lib.errors import InputError
from ur5lib.jobs.declared import declared
from ur5lib.study.given import OF_OTHERS, setting
from ur5lib.study.reading import parse_study, study_text
from ur5lib.study.selection import Selection


def study(folder: Path, after: dict[str, str | None], **entries: dict[str, Any]) -> dict[str, Any]:
    """A study of recordings by name, each with what it follows."""
    recordings = []
    for name, earlier in after.items():
        (folder / f"{name}.csv").touch()
        keys = {"name": name, "robot": "ur5", "format": "rtde-csv", "role": "fit"}
        own = keys | {"folder": str(folder), "file": f"{name}.csv"} | entries.get(name, {})
        recordings.append(own | ({"after": earlier} if earlier else {}))
    return {"study": "mine", "title": "Mine", "recordings": recordings}


def complaints(raw: dict[str, Any]) -> list[str]:
    with pytest.raises(InputError) as error:
        parse_study(raw, "mine.yaml")
    return str(error.value).splitlines()


@pytest.mark.parametrize("seed", range(5))
def test_a_chain_is_known_in_whatever_order_its_entries_stand(tmp_path: Path, seed: int) -> None:
    names = [f"run{k}" for k in range(8)]
    cut = random.Random(seed).randrange(1, 8)  # where a session ends and another begins
    after = {name: names[k - 1] if k not in (0, cut) else None for k, name in enumerate(names)}
    shuffled = dict(random.Random(seed).sample([*after.items()], 8))
    selection = Selection(parse_study(study(tmp_path, shuffled), ""))
    for k, name in enumerate(names):
        assert selection.before(name) == names[cut if k >= cut else 0 : k]
    assert {*selection.before(*names)} == {*names} - {names[cut - 1], names[-1]}


def test_a_circle_is_stated_once(tmp_path: Path) -> None:
    after = {"free": None, "a": "c", "b": "a", "c": "b", "d": "e", "e": "d"}
    first, second = complaints(study(tmp_path, after))
    assert first.startswith(
        "mine.yaml: `recordings.a.after`: a after c after b after a is a circle"
    )
    assert "d after e after d" in second
    (own,) = complaints(study(tmp_path, {"a": "a"}))
    assert "a after a is a circle" in own


def test_a_name_that_is_missing_or_of_another_arm_has_one_sentence(tmp_path: Path) -> None:
    (missing,) = complaints(study(tmp_path, {"run1": None, "run2": "run_1"}))
    assert "`recordings.run2.after`" in missing
    assert "did you mean `run1`?" in missing
    (other,) = complaints(study(tmp_path, {"run1": None, "run2": "run1"}, run2={"robot": "ur10"}))
    assert "a recording of ur5, not of ur10" in other
    (alone,) = complaints(study(tmp_path, {"run1": None, "run2": "previous"}))
    assert "no pattern" in alone


def test_one_recording_alone_comes_directly_after_another(tmp_path: Path) -> None:
    (twice,) = complaints(study(tmp_path, {"a": None, "b": "a", "c": "a"}))
    assert "b, c names a" in twice


def test_postures_without_time_follow_nothing_and_are_not_followed(tmp_path: Path) -> None:
    still = {"format": "table-csv", "columns": ["actual_q", "actual_current"], "still": True}
    (followed,) = complaints(study(tmp_path, {"a": None, "b": "a"}, a=still))
    assert "postures without time" in followed
    (follows,) = complaints(study(tmp_path, {"a": None, "b": "a"}, b=still))
    assert "is `still`, without time, but has `after`" in follows


def with_pattern(folder: Path, after: str, *files: str) -> dict[str, Any]:
    raw = study(folder, {"before": None, "run": after})
    raw["recordings"][1]["file"] = "run-*.csv"
    for file in files:
        (folder / file).touch()
    return raw


def test_the_files_of_a_pattern_follow_each_other_by_their_numbers(tmp_path: Path) -> None:
    files = [f"run-{number}.csv" for number in (9, 10, 2, 100, 1)]
    read = parse_study(with_pattern(tmp_path, "previous", *files), "")
    selection = Selection(read)
    ordered = [f"run_run-{number}" for number in (1, 2, 9, 10, 100)]
    assert [*selection.recordings] == ["before", *ordered]
    assert [selection.before(name) for name in ordered] == [ordered[:k] for k in range(5)]
    again = parse_study(yaml.safe_load(study_text(read)), "")
    assert Selection(again).before(ordered[-1]) == ordered[:-1]


def test_the_files_of_a_pattern_do_not_all_follow_one(tmp_path: Path) -> None:
    (error,) = complaints(with_pattern(tmp_path, "before", "run-1.csv", "run-2.csv"))
    assert "after: previous" in error


def test_a_pattern_without_files_is_one_error(tmp_path: Path) -> None:
    (none,) = complaints(with_pattern(tmp_path, "previous"))
    assert "no file" in none


def test_reading_and_alignment_do_not_know_what_came_before(tmp_path: Path) -> None:
    alone, chained = (
        Selection(parse_study(study(tmp_path, {"a": None, "b": earlier}), ""))
        for earlier in (None, "a")
    )
    for step in ("read_recording", "align_recording", "compute_torques", "estimate_forces"):
        own = declared(step)
        assert own is not None
        assert not own.reads.keys() & OF_OTHERS.keys()
        for name in own.reads:
            if (of := setting(own.of, own.recordings, own.reads[name])) is not None:
                assert of(alone, "b") == of(chained, "b")

"""Mistakes of a study that every command answers alike, before Snakemake starts."""

from pathlib import Path

import pytest

from ur5lib.commands.run import build, state
from ur5lib.errors import InputError
from ur5lib.study.reading import parse_study, read_study

STUDY = """study: s
title: t
recordings:
  - {name: a, robot: ur5, format: rtde-csv, folder: no/a, file: a.csv, role: fit}
  - {name: b, robot: ur5, format: rtde-csv, folder: no/b, file: b.csv, role: fit}
"""


def mistakes(path: Path) -> set[str]:
    """What checking, asking for the state and building say of a study."""
    told = set[str]()
    for ask in (
        lambda: read_study(path),
        lambda: state(path, path.parent / "results"),
        lambda: build(path, path.parent / "results", [], verbose=False),
    ):
        with pytest.raises(InputError) as caught:
            ask()
        told.add(str(caught.value))
    return told


def test_all_commands_say_the_same_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(STUDY)
    (one,) = mistakes(tmp_path / "s.yaml")
    assert len(one.splitlines()) == 1
    assert "`recordings[0].folder` lies in 'no'" in one


def test_a_setting_at_the_top_is_told_where_it_belongs() -> None:
    with pytest.raises(InputError, match="`lowpass` belongs under `settings`"):
        parse_study({"study": "s", "title": "t", "recordings": [], "lowpass": {}}, "s.yaml")


def test_who_would_leave_out_a_joint_is_told_what_to_do() -> None:
    recording = {"name": "a", "format": "rtde-csv", "exclude_joints": [6]}
    raw = {"study": "s", "title": "t", "recordings": [recording], "exclude_joints": [6]}
    with pytest.raises(InputError) as caught:
        parse_study(raw, "s.yaml")
    told = [line for line in str(caught.value).splitlines() if "exclude_joints" in line]
    assert len(told) == 2
    assert all("none can be left out; remove the key, and overrule" in line for line in told)


@pytest.mark.parametrize("reason", [None, "", " "])
def test_a_stop_sign_is_not_overruled_without_a_reason(reason: str | None) -> None:
    raw = {"study": "s", "title": "t", "recordings": [], "accept": {"order": reason}}
    with pytest.raises(InputError, match=r"`accept.order` .*the reason, as text") as caught:
        parse_study(raw, "s.yaml")
    assert str(caught.value).count("accept") == 1


def test_published_values_are_a_mapping(tmp_path: Path) -> None:
    (tmp_path / "list").write_text("root:x:0:0\nnobody:x:1:1\n")
    raw = {"study": "s", "title": "t", "recordings": [], "reference": str(tmp_path / "list")}
    with pytest.raises(InputError, match="does not hold published values"):
        parse_study(raw, "s.yaml")

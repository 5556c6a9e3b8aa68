"""A study: all its errors at once, each with a remedy."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import BaseModel

from tests.command import words
from tests.conftest import PROJECT
from ur5lib.errors import InputError
from ur5lib.study import given
from ur5lib.study.model import Settings, Study, arms_without_fit, schema_text
from ur5lib.study.reading import parse_study
from ur5lib.study.schema import settings_text

GONE = object()


@pytest.fixture
def raw(tmp_path: Path) -> dict[str, Any]:
    recording = {"name": "run", "robot": "ur5", "format": "thesis-csv", "role": "fit"}
    return {
        "study": "mine",
        "title": "Mine",
        "recordings": [recording | {"folder": str(tmp_path)}],
        "settings": {"lowpass": {"motion": {"cutoff_hz": 5.0}}},
    }


def complaints(raw: dict[str, Any]) -> list[str]:
    with pytest.raises(InputError) as error:
        parse_study(raw, "config.yaml")
    return str(error.value).splitlines()


def test_defaults_fill_what_is_not_given(raw: dict[str, Any]) -> None:
    study = parse_study(raw, "config.yaml")
    assert study.settings.lowpass.motion.cutoff_hz == 5.0
    assert study.settings.lowpass.motion.order == 4
    assert study.reference is None


def with_pattern(raw: dict[str, Any], tmp_path: Path, **entry: Any) -> dict[str, Any]:
    """A study of logs by month and arm, one of which has no day in its path."""
    for name in ("2026-03/a_20260309.csv", "2026-04/b 2026-04-01.csv", "2026-04/c.csv", "x.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    keys = {"name": "log", "robot": "ur5", "format": "rtde-csv", "role": "validate"}
    raw["recordings"].append(keys | {"folder": str(tmp_path), "file": "2026-*/*.csv"} | entry)
    return raw


def test_a_pattern_stands_for_a_recording_of_each_file(raw: dict[str, Any], tmp_path: Path) -> None:
    raw["recordings"][0]["folder"] = str(tmp_path.parent)
    found = parse_study(with_pattern(raw, tmp_path), "").recordings[1:]
    assert [(run.name, str(run.date), *run.file_names()) for run in found] == [
        ("log_2026-03-a_20260309", "2026-03-09", "2026-03/a_20260309.csv"),
        ("log_2026-04-b-2026-04-01", "2026-04-01", "2026-04/b 2026-04-01.csv"),
        ("log_2026-04-c", "None", "2026-04/c.csv"),
    ]
    raw["recordings"][1]["date"] = "2025-12-31"
    assert {str(run.date) for run in parse_study(raw, "").recordings[1:]} == {"2025-12-31"}


def test_the_error_of_a_pattern_is_stated_once_at_its_entry(
    raw: dict[str, Any], tmp_path: Path
) -> None:
    raw["recordings"][0]["folder"] = str(tmp_path.parent)
    (error,) = complaints(with_pattern(raw, tmp_path, role="fitt"))
    assert "recordings[1].role" in error
    raw["recordings"][1] |= {"role": "fit", "file": "2027-*/*.csv"}
    (error,) = complaints(raw)
    assert "2027-*/*.csv" in error
    raw["recordings"][1] |= {"file": str(tmp_path / "2027-*" / "*.csv")}  # an absolute path
    (error,) = complaints(raw)
    assert "no file" in error


def test_a_mistake_of_several_recordings_is_stated_once(raw: dict[str, Any]) -> None:
    (run,) = raw["recordings"]
    raw["recordings"] = [run | {"name": f"run{k}", "rate_hz": 125} for k in range(9)]
    raw["recordings"][3] |= {"role": "fitt"}
    (unknown,) = (error for error in complaints(raw) if "rate_hz" in error)
    assert words("`recordings[0].rate_hz` recordings[1], recordings[5], ...") <= words(unknown)
    assert any("`recordings[3].role`" in error for error in complaints(raw))


def changed(raw: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """A study with other values at some places, e.g. `recordings[0].role`; GONE for no value."""
    for place, value in changes.items():
        *parts, last = [int(part) if part.isdigit() else part for part in re.findall(r"\w+", place)]
        node: Any = raw
        for part in parts:
            node = node[part]
        if value is GONE:
            del node[last]
        else:
            node[last] = value
    return raw


RUN = "recordings[0]."
MOTION = "settings.lowpass.motion."
TABLE = {f"{RUN}format": "table-csv", f"{RUN}file": "a.csv"}
HDF5 = {f"{RUN}format": "hdf5", f"{RUN}file": "a.h5"}
IMU = {"file": "b.csv", "columns": ["time"], "tim": 1}


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({f"{MOTION}cutof_hz": 3}, f"`{MOTION}cutof_hz` `cutoff_hz` order"),
        ({f"{MOTION}cutoff_hz": -3}, f"`{MOTION}cutoff_hz` -3; above 0 below 1000"),
        ({f"{MOTION}cutoff_hz": float("nan")}, f"`{MOTION}cutoff_hz` nan; 0 1000"),
        ({f"{RUN}role": "contacts"}, f"`{RUN}role` 'contacts' `contact` fit, validate,"),
        ({f"{RUN}format": "thesis"}, f"`{RUN}format` 'thesis' `thesis-csv` rtde-csv, hdf5,"),
        ({f"{RUN}robot": "UR5"}, f"`{RUN}robot`: `UR5` `ur5`?); docs/robots.md"),
        ({f"{RUN}name": None}, f"`{RUN}name` None; quotes, YAML"),
        (TABLE | {f"{RUN}columns": ["time", "actual_curent"]},
         f"`{RUN}columns[1]` 'actual_curent'; `actual_current`"),
        (HDF5 | {f"{RUN}channels": {"time": "t", "actual_curent": "i"}},
         f"`{RUN}channels` `actual_current` `actual_curent`,"),
        ({f"{RUN}name": "../run"}, f"`{RUN}name` '../run'; letters, digits,"),
        ({f"{RUN}folder": "tests/nowhere"}, f"`{RUN}folder` 'tests/nowhere', {Path.cwd()};"),
        ({f"{RUN}columns": ["time"]}, f"`{RUN}columns`; name, payload, simulate"),
        ({f"{RUN}gravity": [0, 0, 0.981]}, f"`{RUN}gravity` 0.981]; [m/s²] 9 10.5"),
        ({f"{RUN}payload": {"mass": float("nan")}}, f"`{RUN}payload.mass` nan; above 0"),
        (TABLE, f"`{RUN}columns` missing; list 1"),
        ({f"{RUN}format": "rtde-csv", f"{RUN}file": "a.csv", f"{RUN}imu": IMU},
         f"`{RUN}imu.tim` `time` columns, start_file,"),
        (HDF5 | {f"{RUN}channels": {"time": "t", "actual_q": []}}, f"`{RUN}channels` []}}; array"),
        (HDF5 | {f"{RUN}channels": {"actual_q": "q"}}, "`recordings[0]` names `time`; `rate` [Hz]"),
        (TABLE | {f"{RUN}columns": ["actual_q"]}, "`recordings[0]` names `time`; `rate` [Hz]"),
        (TABLE | {f"{RUN}columns": ["time", "actual_q"], f"{RUN}rate": 125},
         "`recordings[0]` both `time` `rate`; remove"),
        (TABLE | {f"{RUN}columns": ["actual_q"], f"{RUN}time": "epoch_s", f"{RUN}rate": 125},
         "`recordings[0]` both `time` `rate`; remove"),
        (HDF5 | {f"{RUN}channels": {"time": "t", "actual_q": "q"}, f"{RUN}joints": [1, 2, 2]},
         f"`{RUN}joints` [1, 2, 2]; each 1 to 3 once"),
        (TABLE | {f"{RUN}columns": ["actual_q"], f"{RUN}rate": 0.5}, f"`{RUN}rate` 0.5; least 1"),
        ({f"{RUN}directions": [1, 0]}, f"`{RUN}directions[1]` 0; 1, -1"),
        ({f"{RUN}format": GONE}, f"`{RUN}format` missing; thesis-csv, channel-files"),
        ({f"{RUN}role": GONE}, f"`{RUN}role` missing; fit, contact"),
        ({"recordings": []}, "`recordings` []; list 1"),
        ({f"{RUN}from_s": 5, f"{RUN}to_s": 2.5}, f"`{RUN}to_s` 2.5, `from_s`, 5;"),
        ({"settings": 3}, "`settings` 3; mapping"),
        ({"hosts": {"pc": ["force_senser"]}}, "`hosts.pc[0]` 'force_senser' `force_sensor`?);"),
        ({"hosts": {"pc": ["imu"], "laptop": ["force_sensor", "imu"]}}, "hosts: imu twice;"),
        ({"hosts": {"pc": "imu"}}, "`hosts.pc` 'imu'; list"),
        ({f"{RUN}date": "next-week"}, f"`{RUN}date` 'next-week'; 2026-03-09"),
        ({"compare_with": ["monday"]}, "`compare_with` 'monday', results/monday `ur5"),
        ({"compare_with": ["mine"]}, "`compare_with` 'mine', itself;"),
    ],
)  # fmt: skip
def test_an_error_names_key_value_range_and_near_name(
    raw: dict[str, Any], changes: dict[str, Any], named: str
) -> None:
    (complaint,) = complaints(changed(raw, changes))
    assert words(f"config.yaml: {named}") <= words(complaint)


@pytest.mark.parametrize(
    ("names", "folders", "named"),
    [(["run", "run"], "/.", "'run' twice"), (["a", "b"], "//", "a b /; `from_s` `to_s`")],
)
def test_two_recordings_differ(
    raw: dict[str, Any], names: list[str], folders: str, named: str
) -> None:
    own = [{"name": n, "folder": f} for n, f in zip(names, folders, strict=True)]
    (complaint,) = complaints(raw | {"recordings": [raw["recordings"][0] | one for one in own]})
    assert words(named) <= words(complaint)


def test_two_recordings_may_be_parts_of_one_file(raw: dict[str, Any]) -> None:
    whole = raw["recordings"][0]
    first, second = whole | {"to_s": 5}, whole | {"name": "second", "from_s": 5}
    assert len(parse_study(raw | {"recordings": [first, second]}, "config.yaml").recordings) == 2
    (complaint,) = complaints(raw | {"recordings": [first, second | {"from_s": 4.9}]})
    assert words("run second `from_s`") <= words(complaint)


FOURIER = {"kind": "fourier"}


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"trajectory": {"kind": "fourie"}}, "trajectory.kind` 'fourie' `fourier`?); movej,"),
        ({"trajectory": {}}, "trajectory.kind` missing; movej, series,"),
        ({"trajectory": {"kind": "fourier", "drw": 3}}, "trajectory.drw` `draw`?); posture,"),
        ({"trajectory": {"kind": "movej", "way_points": "no.txt"}},
         "trajectory.way_points` 'no.txt'; existing file"),
        ({"trajectory": {"kind": "movej", "way_points": [[0] * 6, [0, 0, 0, 0, 0, "x"]]}},
         "trajectory.way_points[1][5]` 'x'; number"),
        ({"trajectory": {"kind": "movej", "way_points": 3}}, "trajectory.way_points` 3; list 2"),
        ({"contacts": [{"kind": "push", "start_s": 1, "force": [1, 2, 3]}, {"kind": "psh"}]},
         "contacts[1].kind` 'psh' `push`?); wall,"),
        ({"contacts": [{"kind": "push", "start_s": -1, "force": [1, 2, 3]}]},
         "contacts[0].start_s` -1; 0"),
        ({"faults": {"lost_frame": 0.1}}, "faults.lost_frame` `lost_frames`?); torn_files,"),
        ({"trajectory": None}, "trajectory` None; mapping"),
    ],
)  # fmt: skip
def test_an_error_in_a_plan_names_as_much(
    raw: dict[str, Any], change: dict[str, Any], named: str
) -> None:
    del raw["recordings"][0]["folder"]
    raw["recordings"][0]["simulate"] = {"trajectory": FOURIER} | change
    (complaint,) = complaints(raw)
    assert words(f"config.yaml: `{RUN}simulate.{named}") <= words(complaint)


def test_a_simulated_recording_needs_no_files(raw: dict[str, Any]) -> None:
    """What the stand will write is as if the study had named it; other names are refused."""
    plan = {"trajectory": FOURIER, "imu": {}}
    simulated = {"name": "b.c", "robot": "ur5", "role": "fit", "simulate": plan}
    raw["recordings"] = [
        {**simulated, "format": "rtde-csv"},
        {**simulated, "format": "thesis-csv", "name": "t"},
    ]
    recording, thesis = parse_study(raw, "config.yaml").recordings
    assert recording.folder == "raw/mine/b.c"
    assert recording.file_names() == ["robot.csv", "imu.csv"]
    assert recording.imu.columns == ["time", "imu_a", "imu_m", "imu_g"]
    assert "csv_files/acc_data.csv" in thesis.file_names()
    raw["recordings"][0]["folder"] = "raw/mine"
    (complaint,) = complaints(raw)
    assert words("`recordings[0].folder` `simulate`") <= words(complaint)


def test_a_plan_s_payload_is_known_where_no_file_can_say_it(raw: dict[str, Any]) -> None:
    """RTDE's channels tell it, and else the study; what the study says itself comes first."""
    plan = {"trajectory": FOURIER, "payload": {"mass": 2}, "undeclared_payload": {"mass": 1}}
    simulated = {"robot": "ur5", "role": "fit", "simulate": plan}
    raw["recordings"] = [
        simulated | {"name": "thesis", "format": "thesis-csv"},
        simulated | {"name": "rtde", "format": "rtde-csv"},
        simulated | {"name": "said", "format": "thesis-csv", "payload": {"mass": 3}},
    ]
    known = [recording.known_payload() for recording in parse_study(raw, "").recordings]
    assert [payload and payload.mass for payload in known] == [2, None, 3]


def test_a_real_recording_still_needs_its_file(raw: dict[str, Any]) -> None:
    raw["recordings"][0] |= {"format": "rtde-csv"}
    (complaint,) = complaints(raw)
    assert words("`recordings[0].file` missing") <= words(complaint)


def test_the_truth_lies_in_the_recording_s_folder(raw: dict[str, Any], tmp_path: Path) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    for place in (tmp_path, folder):
        (place / "truth.json").touch()
        (place / "truth.parquet").touch()
    (folder / "half.json").touch()
    entry = {"name": "run", "robot": "ur5", "format": "rtde-csv", "role": "fit", "file": "a.csv"}
    for truth in ("../truth", "..", "../..", "half", "none", str(folder / "truth"), ""):
        told = complaints(raw | {"recordings": [entry | {"folder": str(folder), "truth": truth}]})
        assert len(told) == 1
        assert told[0].startswith("config.yaml: `recordings[0].truth` is ")
    study = parse_study(
        raw | {"recordings": [entry | {"folder": str(folder), "truth": "truth"}]}, "config.yaml"
    )
    assert getattr(study.recordings[0], "truth", "") == "truth"


def test_many_values_are_said_as_such(raw: dict[str, Any]) -> None:
    (complaint,) = complaints(raw | {"hosts": [0] * 200_000})
    assert "has more than 100,000 values" in complaint


def test_all_errors_are_told_at_once(raw: dict[str, Any]) -> None:
    raw["titel"] = raw.pop("title")
    raw["recordings"][0] |= {"role": "x", "name": "a b"}
    raw["recordings"] *= 2
    raw["settings"]["frames"] = {"max_gap_s": 9}
    errors = complaints(raw)
    assert len(errors) == 7
    assert len([one for one in errors if one.endswith("; the same in recordings[1]")]) == 2


def test_an_arm_without_a_recording_to_fit_on_is_known(raw: dict[str, Any]) -> None:
    other = {"name": "other", "robot": "ur10e", "folder": "/", "role": "contact"}
    raw["recordings"].append(raw["recordings"][0] | other)
    assert arms_without_fit(parse_study(raw, "config.yaml")) == ["ur10e"]


@pytest.mark.parametrize("name", [".", "..", ".hidden", "a/b", "", "ä", "a b"])
def test_a_name_can_be_a_folder(raw: dict[str, Any], name: str) -> None:
    raw["recordings"][0]["name"] = name
    assert "`recordings[0].name`" in complaints(raw)[0]


def test_the_committed_schema_is_the_models() -> None:
    committed = PROJECT / "workflow" / "study.schema.json"
    assert committed.read_text() == schema_text(), "run `make schema`"


def test_the_committed_table_of_settings_is_the_models() -> None:
    committed = PROJECT / "docs" / "settings.md"
    assert committed.read_text() == settings_text(), "run `make schema`"


def test_the_table_of_settings_has_every_key() -> None:
    parts = [Study.model_json_schema(), *Study.model_json_schema()["$defs"].values()]
    text = settings_text()
    for key in {key for part in parts for key in part["properties"]}:
        assert f"\n| `{key}` | " in text


def test_every_setting_is_documented_and_used() -> None:
    """Each field of each part has a description, and a step is given it or its whole part."""
    rules = [*PROJECT.glob("workflow/rules/*.smk"), *PROJECT.glob("ur5lib/topics/*/rules.smk")]
    text = "".join(path.read_text() for path in [*rules, Path(given.__file__)])

    def check(model: Any, place: str) -> None:
        for name, field in model.model_fields.items():
            if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
                check(field.annotation, f"{place}.{name}")
            else:
                assert field.description
                *_, part = place.split(".")
                used = rf"\b{place}\.{name}\b|design\({place}\)|\"{part}(\.{name})?\""
                assert re.search(used, text, re.IGNORECASE), f"{place}.{name}"

    check(Settings, "settings")


def test_the_shipped_studies_are_valid(thesis_data: Path, tmp_path: Path, monkeypatch: Any) -> None:
    (tmp_path / "raw").mkdir()
    (tmp_path / "raw" / "thesis").symlink_to(thesis_data)
    (tmp_path / "workflow").symlink_to(PROJECT / "workflow")
    monkeypatch.chdir(tmp_path)
    studies = [PROJECT / "config.yaml", *(PROJECT / "workflow" / "studies").glob("thesis.yaml")]
    for path in studies:
        parse_study(yaml.safe_load(path.read_text()), path.name)


def test_a_study_file_of_version_0_2_is_read_as_it_was() -> None:
    """Until 1.0, every key that it wrote has its meaning and its value."""
    stored = yaml.safe_load(Path(__file__).with_name("study_of_0_2.yaml").read_text())
    study = parse_study(stored, "study_of_0_2.yaml")
    later = {"pushes": {"per_arm": 900, "posture_deg": None}}  # as many as it tried
    later |= {"friction": {"terms": None, "prior": True}}  # by what the recordings show, as it did
    assert study.settings.model_dump(mode="json") == stored["settings"] | later
    assert [entry.name for entry in study.recordings] == [
        entry["name"] for entry in stored["recordings"]
    ]

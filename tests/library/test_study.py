"""A study: all its errors at once, each with a remedy."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import BaseModel

from tests.conftest import PROJECT
from ur5lib.errors import InputError
from ur5lib.study.model import Settings, Study, arms_without_fit, schema_text
from ur5lib.study.reading import RENAMED, parse_study
from ur5lib.study.settings_table import settings_text

FORMATS = (
    "thesis-csv, realtime-stream, rtde-csv, table-csv, feather, hdf5, mat, parquet, rosbag, "
    "channel-files"
)


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


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (
            lambda raw: raw["settings"]["lowpass"]["motion"].update(cutof_hz=3),
            "unknown key `settings.lowpass.motion.cutof_hz` (did you mean `cutoff_hz`?); "
            "known keys: order, cutoff_hz",
        ),
        (
            lambda raw: raw["settings"]["lowpass"]["motion"].update(cutoff_hz=-3),
            "`settings.lowpass.motion.cutoff_hz` is -3; give a number above 0 and below 1000",
        ),
        (
            lambda raw: raw["settings"]["lowpass"]["motion"].update(cutoff_hz="fast"),
            "`settings.lowpass.motion.cutoff_hz` is 'fast'; give a number above 0 and below 1000",
        ),
        (
            lambda raw: raw["settings"]["lowpass"]["motion"].update(cutoff_hz=float("nan")),
            "`settings.lowpass.motion.cutoff_hz` is nan; give a number above 0 and below 1000",
        ),
        (
            lambda raw: raw["recordings"][0].update(role="contacts"),
            "`recordings[0].role` is 'contacts' (did you mean `contact`?); "
            "give one of fit, validate, contact",
        ),
        (
            lambda raw: raw["recordings"][0].update(robot="ur55"),
            "`recordings[0].robot`: no description of `ur55`; docs/robots.md shows how to add one",
        ),
        (
            lambda raw: raw["recordings"][0].update(format="thesis"),
            "`recordings[0].format` is 'thesis' (did you mean `thesis-csv`?); "
            f"give one of {FORMATS}",
        ),
        (
            lambda raw: raw["recordings"][0].update(name="../run"),
            "`recordings[0].name` is '../run'; "
            "give a string of letters, digits, `_`, `-`; dots too, except as the first character",
        ),
        (
            lambda raw: raw["recordings"][0].update(folder="raw/nowhere"),
            f"`recordings[0].folder` is 'raw/nowhere', which does not exist in {Path.cwd()}; run "
            "in the project's folder, correct the path, or fetch the data (`ur5 fetch`)",
        ),
        (lambda raw: raw["recordings"][0].update(columns=["time"]),
         "unknown key `recordings[0].columns`; known keys: name, robot, folder, role, gravity, "
         "mounting, tool, payload, date, from_s, to_s, format, simulate"),
        (lambda raw: raw["recordings"][0].update(gravity=[0, 0, 0.981]),
         "`recordings[0].gravity` is [0, 0, 0.981]; give three numbers [m/s²] with a magnitude of "
         "9 to 10.5"),
        (lambda raw: raw["recordings"][0].update(payload={"mass": float("nan")}),
         "`recordings[0].payload.mass` is nan; give a number above 0"),
        (lambda raw: raw["recordings"][0].update(format="table-csv", file="a.csv"),
         "`recordings[0].columns` is missing; give a list with at least 1 entry"),
        (lambda raw: raw["recordings"][0].update(
            format="rtde-csv", file="a.csv", imu={"file": "b.csv", "columns": ["time"], "tim": 1}),
         "unknown key `recordings[0].imu.tim` (did you mean `time`?); "
         "known keys: file, columns, units, time, start_file, start"),
        (lambda raw: raw["recordings"][0].update(
            format="hdf5", file="a.h5", channels={"time": "t", "actual_q": []}),
         "`recordings[0].channels` is {'time': 't', 'actual_q': []}; give a mapping in which each "
         "channel names an array"),
        (lambda raw: raw["recordings"][0].update(
            format="hdf5", file="a.h5", channels={"actual_q": "q"}),
         "`recordings[0].channels` is {'actual_q': 'q'}; give a mapping with `time`, which names "
         "the array of the stamps"),
        (lambda raw: raw["recordings"][0].pop("format"),
         f"`recordings[0].format` is missing; give one of {FORMATS}"),
        (lambda raw: raw["recordings"][0].pop("role"),
         "`recordings[0].role` is missing; give one of fit, validate, contact"),
        (lambda raw: raw.update(recordings=[]),
         "`recordings` is []; give a list with at least 1 entry"),
        (lambda raw: raw.update(recordings=[{**raw["recordings"][0], "folder": f} for f in "/."]),
         "recordings: 'run' is used twice as a name; give each recording its own"),
        (lambda raw: raw.update(recordings=[{**raw["recordings"][0], "name": n, "folder": "/"}
                                            for n in "ab"]),
         "recordings: a and b use the same /; give each its own file, or its own part of it by "
         "`from_s` and `to_s`"),
        (lambda raw: raw["recordings"][0].update(from_s=5, to_s=2.5),
         "`recordings[0].to_s` is 2.5, not after `from_s`, 5; correct one"),
        (lambda raw: raw.update(settings=3), "`settings` is 3; give a mapping"),
        (lambda raw: raw.update(hosts={"pc": ["force_senser"]}),
         "`hosts.pc[0]` is 'force_senser' (did you mean `force_sensor`?); "
         "give one of force_sensor, imu"),
        (lambda raw: raw.update(hosts={"pc": ["imu"], "laptop": ["force_sensor", "imu"]}),
         "hosts: imu is listed twice; list it under the host that timestamps its samples"),
        (lambda raw: raw.update(hosts={"pc": "imu"}), "`hosts.pc` is 'imu'; give a list"),
        (lambda raw: raw.update(host={"pc": ["imu"]}),
         "unknown key `host` (did you mean `hosts`?); "
         "known keys: study, title, robot, recordings, reference, compare_with, devices, hosts, "
         "settings"),
        (lambda raw: raw["recordings"][0].update(date="next week"),
         "`recordings[0].date` is 'next week'; give a date, as in 2026-03-09"),
        (lambda raw: raw.update(compare_with=["monday"]),
         "`compare_with` names 'monday', but results/monday holds no results; run snakemake on "
         "that study first"),
        (lambda raw: raw.update(compare_with=[raw["study"]]),
         "`compare_with` names 'mine', this study itself; name another"),
    ],
)  # fmt: skip
def test_an_error_names_key_value_range_and_near_name(
    raw: dict[str, Any], change: Any, sentence: str
) -> None:
    change(raw)
    assert complaints(raw) == [f"config.yaml: {sentence}"]


def test_two_recordings_may_be_parts_of_one_file(raw: dict[str, Any]) -> None:
    whole = raw["recordings"][0]
    first, second = whole | {"to_s": 5}, whole | {"name": "second", "from_s": 5}
    assert len(parse_study(raw | {"recordings": [first, second]}, "config.yaml").recordings) == 2
    assert "use the same" in complaints(raw | {"recordings": [first, second | {"from_s": 4.9}]})[0]


FOURIER = {"kind": "fourier"}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"trajectory": {"kind": "fourie"}},
         "`recordings[0].simulate.trajectory.kind` is 'fourie' (did you mean `fourier`?); "
         "give one of movej, fourier, series, standstill"),
        ({"trajectory": {}},
         "`recordings[0].simulate.trajectory.kind` is missing; "
         "give one of movej, fourier, series, standstill"),
        ({"trajectory": {"kind": "fourier", "drw": 3}},
         "unknown key `recordings[0].simulate.trajectory.drw` (did you mean `draw`?); known keys: "
         "kind, draw, posture, amplitude_rad, period_s, harmonics, limit_share"),
        ({"trajectory": {"kind": "movej", "way_points": "nowhere.txt"}},
         "`recordings[0].simulate.trajectory.way_points` is 'nowhere.txt'; give an existing file"),
        ({"trajectory": {"kind": "movej", "way_points": [[0] * 6, [0, 0, 0, 0, 0, "x"]]}},
         "`recordings[0].simulate.trajectory.way_points[1][5]` is 'x'; give a number"),
        ({"trajectory": {"kind": "movej", "way_points": 3}},
         "`recordings[0].simulate.trajectory.way_points` is 3; "
         "give a list with at least 2 entries"),
        ({"contacts": [{"kind": "push", "start_s": 1, "force": [1, 2, 3]}, {"kind": "psh"}]},
         "`recordings[0].simulate.contacts[1].kind` is 'psh' (did you mean `push`?); "
         "give one of push, hand, spring, wall, load"),
        ({"contacts": [{"kind": "push", "start_s": -1, "force": [1, 2, 3]}]},
         "`recordings[0].simulate.contacts[0].start_s` is -1; give a number at least 0"),
        ({"faults": {"lost_frame": 0.1}},
         "unknown key `recordings[0].simulate.faults.lost_frame` (did you mean `lost_frames`?); "
         "known keys: late_packets, lost_frames, cut_frames, stale_stamps, stale_frames, "
         "torn_files, stale_imu"),
        ({"trajectory": None},
         "`recordings[0].simulate.trajectory` is None; give a mapping"),
    ],
)  # fmt: skip
def test_an_error_in_a_plan_is_told_as_plainly(
    raw: dict[str, Any], change: dict[str, Any], sentence: str
) -> None:
    del raw["recordings"][0]["folder"]
    raw["recordings"][0]["simulate"] = {"trajectory": FOURIER} | change
    assert complaints(raw) == [f"config.yaml: {sentence}"]


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
    assert complaints(raw) == [
        "config.yaml: `recordings[0].folder` names real files, but the entry has `simulate`; "
        "remove one"
    ]


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
    assert complaints(raw) == ["config.yaml: `recordings[0].file` is missing; give a string"]


def test_all_errors_are_told_at_once(raw: dict[str, Any]) -> None:
    raw["titel"] = raw.pop("title")
    raw["recordings"][0] |= {"role": "x", "name": "a b"}
    raw["recordings"] *= 2
    raw["settings"]["frames"] = {"max_gap_s": 9}
    assert len(complaints(raw)) == 9


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
    for key in {key for part in parts for key in part["properties"]}:
        assert f"\n| `{key}` | " in settings_text()


def test_every_setting_is_documented_and_used() -> None:
    """Each field of each part has a description, and a rule passes it or its whole part."""
    rules = "".join(path.read_text() for path in (PROJECT / "workflow" / "rules").glob("*.smk"))

    def check(model: Any, place: str) -> None:
        for name, field in model.model_fields.items():
            if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
                check(field.annotation, f"{place}.{name}")
            else:
                assert field.description
                used = rf"={place}\.{name}\b|\*\*{place}\.model_dump\(\)"
                assert re.search(used, rules), f"{place}.{name}"

    check(Settings, "SETTINGS")


def test_the_shipped_studies_are_valid(thesis_data: Path, tmp_path: Path, monkeypatch: Any) -> None:
    (tmp_path / "raw").mkdir()
    (tmp_path / "raw" / "thesis").symlink_to(thesis_data)
    (tmp_path / "workflow").symlink_to(PROJECT / "workflow")
    monkeypatch.chdir(tmp_path)
    studies = [PROJECT / "config.yaml", *(PROJECT / "workflow" / "studies").glob("thesis.yaml")]
    for path in studies:
        parse_study(yaml.safe_load(path.read_text()), path.name)


OLD_SETTINGS = {
    "repair_frames": {"max_gap_s": 0.2},
    "fit_friction": {"order": 4, "cutoff_hz": 2.0, "terms": []},
    "rebuild_forces": {"min_singular_value": 0.02},
    "estimate_forces": {"contact_force_n": 10},
    "set_threshold": {"false_alarms_per_min": 2},
}


def test_each_setting_of_an_earlier_version_is_told_its_new_name(raw: dict[str, Any]) -> None:
    sentences = complaints(raw | {"settings": OLD_SETTINGS})
    assert len(sentences) == sum(len(keys) for keys in OLD_SETTINGS.values())
    moved = "`settings.fit_friction.terms` is now `settings.friction.terms`; move the value there"
    assert f"config.yaml: {moved}" in sentences


def test_new_names_of_settings_exist() -> None:
    """What a message suggests is a key of the model."""
    for keys in RENAMED.values():
        for new in keys.values():
            setting: Any = Settings()
            for part in new.split("."):
                setting = getattr(setting, part)


def test_an_unknown_key_beside_a_renamed_one_is_reported_too(raw: dict[str, Any]) -> None:
    sentences = complaints(raw | {"settings": {"fit_friction": {"order": 4, "ordre": 4}}})
    assert any("unknown key `settings.fit_friction`" in sentence for sentence in sentences)
    assert any("`settings.lowpass.currents.order`" in sentence for sentence in sentences)

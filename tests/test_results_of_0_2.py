"""Results of version 0.2 are read: findings had values, rows were nested, live had columns here.

`study_of_0_2.json` has files of a study, by their places, as the last code of 0.2 (commit 1dd188b1)
built it from the two simulated recordings of tests/workflow/test_simulated.py, without samples and
fits.
"""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.workflow.test_simulated import POINTS
from ur5lib.commands.verdicts import card_states, lines
from ur5lib.finished import StudyFiles
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.friction import Friction
from ur5lib.records.quality import Quality
from ur5lib.report.summary import last_summary
from ur5lib.tables import read_record

FINDINGS = [
    {"device": "robot", "finding": "lost frames", "severity": "warning", "count": 2}
    | {"values": {"steps": [{"code": "steps", "values": {"count": 2}}]}, "code": ""},
    {"device": "force", "finding": "saturation", "severity": "warning", "count": 3}
    | {"values": {"names": ["ft_fx"]}, "code": ""},
    {"device": "robot", "finding": "contradiction", "severity": "stop", "count": 1}
    | {"values": {"joint": 2, "kind": "order"}, "code": "exchanged joints"},
]
OFFSET = dict.fromkeys(["bias", "bias_std", "noise", "start_bias"], [0.1] * 6)
OFFSET |= dict.fromkeys(
    ["moment_arm", "moment_arm_std", "pull_at", "drift", "drift_std"], [0.0] * 3
)
OFFSET |= dict.fromkeys(["mass", "mass_std", "agreeing", "rival", "clock_std", "free"], 0.5)
SENSOR = {
    "offset": OFFSET | {"inertia": None},
    "offset_doubt": {"code": "two biases", "values": {"share": 0.5, "other": 0.4}},
    "mounting_doubt": None,
    "felt": {"largest": 20.0, "at_s": 1.0, "contact": 0.1, "contacts": 2},
    "errors": {"compensated": {"Fmap": {"contact": {"mae": {"Fx": 1.0}}}}},
    "contacts": {"Fmap": []},
}
JUDGEMENT = {"rows": {"files": [{"file": "a.csv", "sha256": "f"}]}, "findings": FINDINGS}
FRICTION = {"from": ["free"], "refused": {"code": "no fit recording", "values": {"channel": "x"}}}


@pytest.fixture
def results(tmp_path: Path) -> StudyFiles:
    """A folder as 0.2 wrote it."""
    recording, arm = tmp_path / "recordings" / "pushed", tmp_path / "parameters" / "ur5"
    for folder in (recording, arm, tmp_path / "tables"):
        folder.mkdir(parents=True)
    for path, data in (
        (recording / "quality.json", {"findings": FINDINGS, "frames": 9}),
        (recording / "judgement.json", JUDGEMENT),
        (recording / "beside_sensor.json", SENSOR),
        (arm / "friction.json", FRICTION),
    ):
        path.write_text(json.dumps(data))
    detection = {"recording": ["pushed"], "estimate": ["Fmap"], "found": [3], "causal_found": [2]}
    pd.DataFrame(detection).to_csv(tmp_path / "tables" / "detection.csv", index=False)
    return StudyFiles(tmp_path)


def test_findings_have_their_codes_as_sentences(results: StudyFiles) -> None:
    quality = results.quality("pushed")
    assert quality.frames == 9
    assert quality.saturated_channels() == ["ft_fx"]
    lost, _, sign = quality.findings
    assert lost.sentence() == "lost frames"
    assert [lost.code, sign.code] == [Found.LOST_FRAMES, Found.CONTRADICTION]
    assert (sign.cause, sign.joints, sign.kind) == (CauseCode.EXCHANGED_JOINTS, (2,), "order")
    assert sign.sentence().startswith("exchanged joints")
    assert results.judgement("pushed").findings == quality.findings


def test_what_was_fitted_and_the_account_of_a_sensor_are_read(results: StudyFiles) -> None:
    friction = results.parameters(Friction, "ur5", "friction")
    assert friction.from_ == ["free"]
    assert friction.refused is not None
    assert friction.refused.sentence() == "no fit recording"
    sensor = results.beside_sensor("pushed")
    assert sensor.offset is not None
    np.testing.assert_array_equal(sensor.offset.bias, [0.1] * 6)
    (doubt,) = sensor.findings()
    assert doubt.code == Found.OFFSET


def test_findings_of_1_0_have_the_codes_of_their_names(tmp_path: Path) -> None:
    """It wrote the name of a finding, and its cause as `code`; other names are of no use here."""
    named = {"device": "robot", "severity": "warning", "count": 1, "detail": "so"}
    names = {"byte-order mark": "", "links in doubt": "missing spring", "of a lab": "its own"}
    findings = [named | {"finding": name, "code": cause} for name, cause in names.items()]
    (tmp_path / "quality.json").write_text(json.dumps({"findings": findings}))
    read = read_record(Quality, tmp_path / "quality.json").findings
    assert [(one.code, one.cause) for one in read] == [
        (Found.BYTE_ORDER_MARK, None),
        (Found.LINKS_IN_DOUBT, CauseCode.MISSING_SPRING),
        (Found.OTHER, CauseCode.OTHER_REASON),
    ]


def test_a_table_has_the_columns_that_it_had(results: StudyFiles) -> None:
    assert results.table("detection")["causal_found"].tolist() == [2]


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of results of the study that 0.2 built."""
    folder = tmp_path_factory.mktemp("results") / "made"
    texts = json.loads(Path(__file__).with_name("study_of_0_2.json").read_text())
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def test_a_study_that_0_2_built_opens(built: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In its workspace, where the files lie that its configuration names."""
    monkeypatch.chdir(built.parent)
    Path("points.txt").write_text(POINTS)
    study = StudyFiles(built)
    assert study.recordings == ["held.1", "moved"]
    assert [study.recording(name).role for name in study.recordings] == ["contact", "fit"]
    assert {len(study.table(name).columns) > 1 for name in study.tables} == {True}
    assert study.summary()["duration [s]"].tolist() == [3.0, 2.0]
    assert {one.code for one in study.quality("moved").findings} == {Found.NO_SENSOR}
    assert study.arm("ur5").is_ur()
    assert set(study.uses["use"]) <= {"yes", "no"}


def test_verdicts_of_0_2_are_printed_and_are_those_of_its_last_build(built: Path) -> None:
    states = card_states(built)
    assert states
    assert all(": " in line for line in lines(states, "made"))
    summary = last_summary(built / "results.json")
    assert summary is not None
    assert len(summary.verdicts) == len(StudyFiles(built).verdicts)

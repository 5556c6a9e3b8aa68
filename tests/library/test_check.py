"""`ur5 check`: a study looked through in seconds, without the workflow."""

from pathlib import Path

import pandas as pd
import pytest

from tests.made_tables import table
from tests.synthetic import write_recording
from ur5lib import cli
from ur5lib.commands.check import unfiltered
from ur5lib.report.findings import group_findings
from ur5lib.study.model import Settings, Study


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")
    write_recording(tmp_path / "raw" / "good", seconds=2, seed=0, force_sensor=True)
    write_recording(tmp_path / "raw" / "bad", seconds=2, seed=1)
    path = tmp_path / "study.yaml"
    path.write_text(
        "study: mine\ntitle: Mine\nrecordings:\n"
        "- {name: good, robot: ur5, format: thesis-csv, folder: raw/good, role: fit}\n"
        "- {name: bad, robot: ur5, format: thesis-csv, folder: raw/bad, role: fit}\n"
    )
    return path


def run(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int:
    monkeypatch.setattr("sys.argv", ["ur5", *map(str, arguments)])
    with pytest.raises(SystemExit) as stop:
        cli.main()
    return int(stop.value.code or 0)


def test_findings_and_clocks_are_printed(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    assert run(monkeypatch, "check", study) == 0
    text = capsys.readouterr().out
    assert "force: no sensor (note)" in text
    assert "0.0050 ± 0.0058" in text
    assert not (study.parent / "results").exists()


def test_an_unusable_recording_does_not_hide_the_others(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    (study.parent / "raw/bad/csv_files/log_q_actual.csv").write_text("nothing\n")
    assert run(monkeypatch, "check", study) == 1
    text = capsys.readouterr().out
    assert "robot: unusable (error)" in text
    assert "good" in text


def test_a_recording_that_is_not_simulated_yet_is_told(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    """It is no fault, and hides nothing."""
    plan = "{trajectory: {kind: fourier}}"
    entry = f"- {{name: made, robot: ur5, format: thesis-csv, role: fit, simulate: {plan}}}\n"
    study.write_text(study.read_text() + entry)
    assert run(monkeypatch, "check", study) == 0
    text = capsys.readouterr().out
    assert "not simulated yet: made; `snakemake` will simulate it first\n" in text
    assert "good" in text


def test_an_arm_without_a_recording_to_fit_on_is_told(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    study.write_text(study.read_text().replace("role: fit", "role: contact"))
    assert run(monkeypatch, "check", study) == 0
    assert "no recording of ur5 has the role `fit`" in capsys.readouterr().out


def test_an_unusable_sensor_is_an_error(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    force = study.parent / "raw/good/csv_files/log_force_sensor.csv"
    force.write_text(force.read_text().replace("\n", ", 0\n"))
    assert run(monkeypatch, "check", study) == 1
    assert "force: unusable sensor (error)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("study: mine\ntitle: [", "study.yaml, line 2: cannot be read as YAML (expected"),
        ("a letter", "is not a study"),
        ("study: mine", "`title` is missing"),
        ("study: \udcff", "cannot be read as YAML ('utf-8' codec"),
        (None, "No such file"),
    ],
)
def test_a_wrong_study_is_told(
    study: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture,
    content: str | None,
    sentence: str,
) -> None:
    if content is None:
        study.unlink()
    else:
        study.write_text(content, errors="surrogateescape")
    assert run(monkeypatch, "check", study) == 1
    assert sentence in capsys.readouterr().err


def test_copies_and_poor_clocks_are_findings() -> None:
    finding = {"device": "robot", "finding": "torn", "severity": "note", "count": 1}
    torn = [finding | {"detail": f"{name}, line 3: left out"} for name in "ab"]
    quality = {"devices": ["robot", "imu"], "files": {"imu": "x"}, "findings": torn}
    stale = {"devices": ["robot"], "files": {"imu": "x"}, "findings": []}
    poor = {"warning": "the arm rests", "offset_std": 0.1, "end_std": 0.2, "drift": None}
    fair = {"warning": None, "offset_std": 0.006, "end_std": 0.1, "drift": None}
    clocks = {"one": {"imu": poor}, "two": {"force": fair, "imu": fair | {"drift": -0.003}}}
    forces = {"one": {"mounting_doubt": None}, "two": {"mounting_doubt": "upside down"}}
    forces["two"]["offset_doubt"] = "a push"
    qualities = {"one": quality, "two": stale}
    rows = table("quality", quality=qualities, clocks=clocks, forces=forces, loads={})
    grouped = group_findings(rows)
    told = grouped.set_index(["recording", "finding"])["detail"].to_dict()
    assert told["one", "torn"] == "a, line 3; b, line 3: left out"
    assert told["one", "same file"] == "identical to the file of two; used here"
    assert told["two", "same file"] == "identical to the file of one; not used here"
    assert told["two", "mounting"] == "upside down"
    assert told["two", "offset"] == "a push"
    assert ("one", "mounting") not in told
    assert told["one", "clock by stamps alone"] == (
        "the arm rests; accurate to 0.1 s at the start and 0.2 s at the end"
    )
    assert "accurate to 0.006 s at the start and 0.1 s at the end" in told["two", "unknown drift"]
    assert list(grouped["finding"]).count("unknown drift") == 1


def test_findings_of_two_meanings_keep_both() -> None:
    finding = {"recording": "one", "device": "robot", "finding": "apart", "severity": "warning"}
    details = ["a: b lie apart", "actual_current and target_current lie apart"]
    rows = [finding | {"count": 1, "detail": detail} for detail in details]
    (told,) = group_findings(pd.DataFrame(rows))["detail"]
    assert told == "a: b lie apart; actual_current and target_current lie apart"


def test_a_recording_that_a_filter_leaves_as_it_is_is_told() -> None:
    settings = Settings.model_validate({"lowpass": {"motion": {"cutoff_hz": 80}}})
    study = Study.model_construct(settings=settings)
    assert unfiltered(study, 0.002) == []
    (note,) = unfiltered(study, 0.008)
    assert note.detail.startswith("`cutoff_hz` of motion is not below 62.5 Hz, half the rate")

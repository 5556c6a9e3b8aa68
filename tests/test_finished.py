"""Results of a study as data frames."""

from dataclasses import asdict, fields
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ur5lib
from ur5lib.errors import InputError
from ur5lib.finished import FILES_OF_ARM, StudyFiles
from ur5lib.jobs.unreadable import marked
from ur5lib.records.carried import Carried
from ur5lib.records.friction import Friction
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Contradictions
from ur5lib.records.verdicts import RecordingUse, Verdict
from ur5lib.robots.description import Payload
from ur5lib.tables import write_csv, write_json, write_rows, write_table, write_text


@pytest.fixture
def results(tmp_path: Path) -> Path:
    folder = tmp_path / "results" / "mine"
    forces = pd.DataFrame({"time": [0.0, 0.1], "Fmap_Fx": [1.0, np.nan], "Fmap_nx": [0.1, 0.2]})
    units = {"Fmap_Fx": "N", "Fmap_nx": "Nm"}
    write_table(forces, folder / "recordings" / "pushed" / "forces.parquet", units)
    write_csv(pd.DataFrame({"joint": [1], "value": [2.5]}), folder / "tables" / "friction.csv")
    return folder


def test_a_recording_s_frame_has_time_channels_and_units(results: Path) -> None:
    forces = ur5lib.load(results).forces("pushed")
    assert [*forces.index] == [0.0, 0.1]
    assert [*forces["Fmap_nx"]] == [0.1, 0.2]
    assert forces.attrs["units"] == {"time": "s", "Fmap_Fx": "N", "Fmap_nx": "Nm"}


def test_a_study_is_found_by_its_name(results: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(results.parents[1])
    for address in ("mine", "results/mine", results, results / "report.html"):
        assert ur5lib.load(address).recordings == ["pushed"]
    with pytest.raises(InputError, match="other"):
        ur5lib.load("other")


def test_what_states_nothing_has_no_deviation(results: Path) -> None:
    wave = {"time": [0.0, 0.1], "Fmap_Fx": [0.0, 4.0], "Fmap_std_Fx": [0.0, 1.0]}
    units = dict.fromkeys(["Fmap_Fx", "Fmap_std_Fx"], "N")
    write_table(pd.DataFrame(wave), results / "recordings/pushed/forces.parquet", units)
    forces = ur5lib.load(results).forces("pushed")
    assert forces.iloc[0].isna().all()
    assert [*forces.iloc[1]] == [4.0, 1.0]


def test_what_there_is_has_names(results: Path) -> None:
    study = ur5lib.load(str(results))
    assert study.recordings == ["pushed"]
    assert study.tables == ["friction"]
    assert study.table("friction")["value"].item() == 2.5


@pytest.mark.parametrize(
    ("what", "name", "known"),
    [
        ("forces", "pushd", "pushed"),
        ("table", "frition", "friction"),
        ("motion", "pushed", "forces"),
    ],
)
def test_the_nearest_name_is_offered(results: Path, what: str, name: str, known: str) -> None:
    with pytest.raises(InputError, match=f"'.*', but {known}"):
        getattr(ur5lib.load(results), what)(name)


def test_the_payload_is_that_of_the_premises(results: Path) -> None:
    carried = Carried(Payload(mass=1.5), "study", None)
    write_json(Premises(carried, Contradictions()), results / "recordings/pushed/premises.json")
    assert StudyFiles(results).payload("pushed") == Payload(mass=1.5)


def test_a_model_takes_the_table_of_currents_and_not_the_summary_beside_it(results: Path) -> None:
    """Both are called `currents`: currents.parquet and currents.json."""
    entry = {"name": "pushed", "robot": "ur5", "role": "fit"}
    write_json({"recordings": [entry], "settings": {}}, results / "configuration.yaml")
    for file in FILES_OF_ARM.values():
        write_text("{}", results / "parameters" / "ur5" / file)
    for file in ("currents.parquet", "currents.json", "payload.json"):
        write_text("{}", results / "recordings" / "pushed" / file)
    own = ur5lib.load(results).model("ur5")._fitted["pushed"]
    assert own == {
        name: results / "recordings" / "pushed" / file
        for name, file in (("currents", "currents.parquet"), ("payload", "payload.json"))
    }


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="ur5 run"):
        ur5lib.load(tmp_path)


@pytest.mark.parametrize("file", ["configuration.yaml", "parameters/ur5/arm.yaml"])
@pytest.mark.parametrize("content", ["", "recordings: [{name: a,", "\0\0\0"])
def test_a_damaged_file_of_settings_is_a_result_to_be_made_anew(
    results: Path, file: str, content: str
) -> None:
    (results / file).parent.mkdir(parents=True, exist_ok=True)
    (results / file).write_text(content)
    study = StudyFiles(results)
    with pytest.raises(InputError, match=rf"{file} is damaged .*rm \S*{file}\)"):
        study.arm("ur5") if "arm" in file else study.configuration()


def test_results_are_read_where_their_recordings_are_gone(results: Path, tmp_path: Path) -> None:
    """As those of a fit of what was given in memory, or of a folder that was moved."""
    gone = {"format": "rtde-csv", "folder": str(tmp_path / "gone"), "file": "free.csv"}
    entry = {"name": "free", "robot": "ur5", "role": "fit", **gone}
    plain = {"study": "mine", "title": "Mine", "recordings": [entry]}
    write_json(plain, results / "configuration.yaml")
    assert StudyFiles(results).recording("free").folder == gone["folder"]
    write_json(plain | {"recordings": [entry | {"role": "none"}]}, results / "configuration.yaml")
    with pytest.raises(InputError, match=r"yaml: `recordings\[0\].role` is 'none'"):
        StudyFiles(results).configuration()


def test_verdicts_and_uses_are_frames(results: Path) -> None:
    rows = [Verdict(question="force", state="good"), Verdict(question="links", arm="1e5", joint=2)]
    write_rows(Verdict, rows, results / "tables" / "verdicts.csv")
    uses = [RecordingUse(recording="pushed", purpose="fit", use="no", reason="touched")]
    write_rows(RecordingUse, uses, results / "tables" / "uses.csv")
    study = ur5lib.load(results)
    assert [*study.verdicts] == [one.name for one in fields(Verdict)]
    assert [*study.verdicts["arm"].fillna("")] == ["", "1e5"]
    assert study.uses.to_dict("records") == [asdict(own) for own in uses]


@pytest.mark.parametrize("name", ["verdicts", "uses"])
def test_results_without_verdicts_say_so_in_one_line(results: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"no verdicts, .* earlier version; `ur5 run mine` again$"):
        getattr(ur5lib.load(results), name)


def test_a_recording_that_cannot_be_read_says_why(results: Path) -> None:
    folder = results / "recordings" / "pushed"
    for file in ("forces.parquet", "quality.json"):
        (folder / file).write_text(marked("line 3: no number"))
    study = StudyFiles(results)
    for read in (study.forces, study.quality, study.start):
        with pytest.raises(InputError, match=r"recordings/pushed/.* cannot be read: line 3"):
            read("pushed")


def test_a_missing_file_is_named(results: Path) -> None:
    with pytest.raises(InputError, match=r"parameters/ur5/friction\.json.*ur5 run"):
        StudyFiles(results).parameters(Friction, "ur5", "friction")

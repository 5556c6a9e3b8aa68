"""A study of efforts in an unknown unit: no newton is stated or exported, and the page says why."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from tests.command import Command
from tests.conftest import Workflow, build_once
from tests.stored_files import made_up_channels
from ur5lib.commands.exported import FORMATS
from ur5lib.tables import named, read_csv, read_table

OWN_CODE = {"live.py", "live.hpp", "live.schema.json"}  # of the estimator, the same for every arm
OF_EFFORTS = ("forces", "live_forces", "currents", "sensor")


@pytest.fixture(scope="module")
def study(common_folder: Path) -> Workflow:
    """Currents of a made-up arm, times a factor a joint, of a fit and of a contact recording."""

    def prepare(folder: Path) -> None:
        entries = []
        for seed, (name, role) in enumerate({"free": "fit", "pushed": "contact"}.items()):
            (folder / f"made_{name}").mkdir()
            time, channels = made_up_channels(folder / f"made_{name}", 8, seed)
            effort = channels["actual_current"] * np.linspace(40, 120, 6)
            table = {"time": time} | named(channels["actual_q"], "actual_q")
            pd.DataFrame(table | named(effort, "actual_current")).to_csv(
                folder / f"{name}.csv", index=False
            )
            entries.append(
                {"name": name, "robot": "ur5", "role": role, "format": "table-csv"}
                | {"folder": ".", "file": f"{name}.csv", "units": {"actual_current": "unknown"}}
                | {"columns": ["time", "actual_q", "actual_current"]}
            )
        plain = {"study": "unknown", "title": "Unknown", "recordings": entries}
        (folder / "config.yaml").write_text(yaml.safe_dump(plain))

    return build_once(common_folder / "unknown", prepare)


@pytest.mark.slow
def test_no_newton_follows_from_an_unknown_unit(study: Workflow, run_ur5: Command) -> None:
    results = study.folder / "results" / "unknown"
    for recording in ("free", "pushed"):
        for file in OF_EFFORTS:
            table = read_table(results / "recordings" / recording / f"{file}.parquet")
            assert not np.isfinite(table.drop(columns=["time", "segment"]).to_numpy(float)).any()
    verdicts = read_csv(results / "tables" / "verdicts.csv").set_index(["question", "rank"])
    assert verdicts.loc[("force", 1), "state"] == "do not use"
    page = " ".join((results / "report.html").read_text().split())
    assert "the unit of actual_current is unknown" in page
    assert "--unit actual_current=A, mA" in page
    for format in sorted({*FORMATS} - OWN_CODE):
        asked = ("export", "--robot", "ur5", "--results", results, "--format", format)
        assert run_ur5(*asked).status == 1, format
    for format in ("live", "thresholds", "thresholds.script", "sensor"):
        asked = ("export", "--robot", "ur5", "--results", results, "--format", format)
        assert run_ur5(*asked, "--accept", "known on a bench").status == 1, format

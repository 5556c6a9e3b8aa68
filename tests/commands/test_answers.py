"""What `ur5 payload` says of a mass, from rows of the table with a known answer."""

import json
import re
from pathlib import Path

import pandas as pd
import pytest

from tests.command import Command
from ur5lib.commands.answers import _carried
from ur5lib.datasets.catalogue import catalogue

NOTHING = pd.DataFrame(columns=["quantity"])


def said(mass: float, low: float, high: float, configured: float = 0.0) -> str:
    row = {"mass": mass, "low": low, "high": high, "configured": configured}
    row |= {"center_of_mass_x": float("nan")}
    (told,) = _carried(pd.DataFrame([row]), NOTHING)
    return told.partition(", configured")[0]


@pytest.mark.parametrize(
    ("found", "numbers"),
    [
        ((-0.16, -0.29, -0.02), ["0.29"]),
        ((0.02, -0.01, 0.05), ["0.05"]),
        ((0.0, -147.65, 147.65), ["148"]),
        ((2.78, 2.60, 2.95), ["2.78", "2.60", "2.95"]),
        ((-0.16, -0.29, -0.02, 0.5), ["0.34", "0.21", "0.48"]),
    ],
)
def test_a_mass_is_never_negative(found: tuple[float, ...], numbers: list[str]) -> None:
    told = said(*found)
    assert re.findall(r"[-−]?\d[\d.]*", told) == numbers


def test_the_answer_is_json_for_a_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    monkeypatch.chdir(tmp_path)
    entry = "robot: ur5e, format: rtde-csv, folder: ., role: contact"
    entries = "".join(f"- {{name: {name}, {entry}, file: {name}.csv}}\n" for name in "ab")
    Path("mine.yaml").write_text(f"study: mine\ntitle: Mine\nrecordings:\n{entries}")
    tables = Path("results/mine/tables")
    tables.mkdir(parents=True)
    (tables / "payload.csv").write_text("recording,mass,low,high,configured\na,1.5,1.4,1.6,0.5\n")
    (tables / "audit.csv").write_text(
        "recording,quantity,component,value,low,high\na,mass,,2.1,2,2.2\nb,turn,,1,0,2\n"
    )
    by_currents = {"mass": 2.0, "low": 1.9, "high": 2.1, "configured": 0.5}
    by_sensor = {"value": 2.1, "low": 2.0, "high": 2.2}
    assert json.loads(run_ur5("payload", "mine.yaml", "--json").out) == [
        {"recording": "a", "currents": by_currents, "sensor": by_sensor},
        {"recording": "b", "currents": None, "sensor": None},
    ]
    audited = json.loads(run_ur5("audit", "mine.yaml", "--json").out)
    assert [row["quantity"] for row in audited] == ["mass", "turn"]


@pytest.mark.parametrize(
    "cause", ["the unit is unknown: --unit", "the load changes: 2.0 kg from 4 s"]
)
def test_a_stop_sign_says_why_no_mass_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command, cause: str
) -> None:
    """Its own, and that of a recording on which its arm would be fitted."""
    monkeypatch.chdir(tmp_path)
    entry = "robot: ur5e, format: rtde-csv, folder: ."
    runs = {"a": "fit", "b": "contact", "c": "contact"}
    entries = "".join(
        f"- {{name: {name}, {entry}, file: {name}.csv, role: {role}}}\n"
        for name, role in runs.items()
    )
    Path("mine.yaml").write_text(f"study: mine\ntitle: Mine\nrecordings:\n{entries}")
    tables = Path("results/mine/tables")
    tables.mkdir(parents=True)
    (tables / "payload.csv").write_text("recording,mass,low,high,configured\n")
    rows = [["a", "stop", "contradiction", cause], ["c", "stop", "contradiction", "its own"]]
    quality = pd.DataFrame(rows, columns=["recording", "severity", "code", "detail"])
    quality.to_csv(tables / "quality.csv", index=False)
    a, b, c = run_ur5("payload", "mine.yaml").out.splitlines()
    assert a == f"a: undetermined by currents ({cause})"
    assert b == f"b: undetermined by currents (a: {cause})"
    assert c == "c: undetermined by currents (its own)"


def test_data_sets_are_listed_as_json(run_ur5: Command) -> None:
    listed = json.loads(run_ur5("fetch", "--json").out)
    assert listed["ur10-bag"]["study"] == catalogue()["ur10-bag"].study


def test_a_mass_that_nothing_determines_is_not_called_no_load() -> None:
    assert "do not determine" in said(0.0, -147.65, 147.65)
    assert "no certain load" in said(-0.16, -0.29, -0.02)

"""The provenance of results, as others' tools read it."""

import json
from pathlib import Path
from typing import Any

import pytest
import requests
import rocrate
from rocrate_validator import models, services
from rocrate_validator.utils.http import HttpRequester

from tests.conftest import PROJECT
from ur5lib.report.page.crate import run_crate
from ur5lib.strict import read_yaml
from ur5lib.tables import checksum

TERMS = Path(rocrate.__file__).parent / "data" / "ro-crate.jsonld"
EARLIER = {  # terms that version 1.1 of this vocabulary had elsewhere
    name: f"https://bioschemas.org/{name}" for name in ("ComputationalWorkflow", "FormalParameter")
}


@pytest.fixture
def results(tmp_path: Path) -> Path:
    """A folder of results, and its description."""
    folder = tmp_path / "mine"
    (folder / "tables").mkdir(parents=True)
    for name in ("Snakefile", "configuration.yaml", "report.html", "tables/force_mae.csv"):
        (folder / name).write_text(name)
    (tmp_path / "raw.csv").write_text("1,2,3")
    made = [str(folder / name) for name in ("report.html", "tables/force_mae.csv")]
    citation = read_yaml(PROJECT / "CITATION.cff")
    crate = run_crate(folder, "My arm", [str(tmp_path / "raw.csv")], made, citation, {})
    (folder / "ro-crate-metadata.json").write_text(json.dumps(crate))
    return folder


def entities(folder: Path) -> dict[str, dict[str, Any]]:
    graph = json.loads((folder / "ro-crate-metadata.json").read_text())["@graph"]
    return {entity["@id"]: entity for entity in graph}


def faults(folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What the validator of RO-Crates finds; it gets the vocabulary without a network."""
    terms = json.loads(TERMS.read_text())["@context"] | EARLIER

    def get(_: HttpRequester, url: str, **__: object) -> requests.Response:
        response = requests.Response()
        response.url, response.status_code = url, 200 if url.endswith("/context") else 504
        response.headers["Content-Type"] = "application/ld+json"
        response._content = json.dumps({"@context": terms}).encode()
        return response

    monkeypatch.setattr(HttpRequester, "get", get, raising=False)
    settings = services.ValidationSettings(
        rocrate_uri=str(folder),
        profile_identifier="workflow-run-crate-0.5",
        requirement_severity=models.Severity.REQUIRED,
        offline=True,
    )
    return [str(issue.message) for issue in services.validate(settings).get_issues()]


def test_it_is_valid_unless_a_file_is_missing(
    results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert faults(results, monkeypatch) == []
    (results / "tables" / "force_mae.csv").unlink()
    assert any("force_mae.csv" in fault for fault in faults(results, monkeypatch))


def test_every_file_is_known_by_its_checksum(results: Path) -> None:
    found = entities(results)
    [recording] = [one for name, one in found.items() if name.startswith("urn:")]
    assert recording["@id"] == f"urn:sha256:{checksum(results.parent / 'raw.csv')}"
    for name in ("configuration.yaml", "report.html", "tables/force_mae.csv"):
        assert found[name]["sha256"] == checksum(results / name)


def test_the_run_led_from_recordings_and_settings_to_results(results: Path) -> None:
    found = entities(results)
    run = found["#run"]
    assert run["instrument"] == {"@id": "Snakefile"}
    assert {one["@id"] for one in run["result"]} == {"report.html", "tables/force_mae.csv"}
    assert {"@id": "configuration.yaml"} in run["object"]
    software = {one["@id"] for one in found["Snakefile"]["softwareRequirements"]}
    assert {"#Python", "#numpy", "#snakemake"} <= software
    assert found[found["Snakefile"]["author"][0]["@id"]]["name"] == "The ur5lib developers"

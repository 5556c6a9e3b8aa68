"""The whole report of a study, from its results."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from ur5lib.report.closed_loop_section import closed_loop_blocks
from ur5lib.report.current_section import current_blocks
from ur5lib.report.document import Block, Cell, Code, Document, Items, Paragraph, Section, Table
from ur5lib.report.force_section import force_blocks
from ur5lib.report.motion_section import motion_blocks
from ur5lib.report.recordings_section import recording_blocks
from ur5lib.report.reference import Erratum
from ur5lib.report.torque_section import torque_blocks
from ur5lib.report.truth_section import truth_blocks, truth_findings
from ur5lib.report.verdict import findings


def compose(
    study: Mapping[str, Any],
    tables: Mapping[str, pd.DataFrame],
    qualities: Mapping[str, Any],
    figures: Path,
    errata: Sequence[Erratum],
    provenance: list[Block],
) -> Document:
    """The report of a study.

    study: the configuration; tables: results by name; qualities: quality.json by recording;
    figures: holds a folder of figures for each recording. With simulated recordings, there is a
    table `truth`, and every page says so.
    """
    roles = {recording["name"]: recording["role"] for recording in study["recordings"]}
    judged = [name for name, role in roles.items() if role == "validate"]
    currents = tables["current_rmse"]
    tables = {**tables, "current_rmse": currents[currents["recording"].isin(judged)]}
    found = findings(tables["torque_mae"], tables["force_mae"], tables["quality"])
    beside_truth = []
    if "truth" in tables:
        found += truth_findings(tables["truth"])
        beside_truth = [Section("Estimates against the truth", truth_blocks(tables["truth"]))]
    quality = recording_blocks(roles, qualities, tables["quality"], tables["clocks"])
    sections = [
        Section("What was found", [Items(found)]),
        Section("Recordings and their quality", quality),
        *_results(tables, figures),
        *beside_truth,
        *([_errata_section(errata)] if errata else []),
        Section("Provenance", [*provenance, *_configuration(study)]),
    ]
    subtitle = f"Study “{study['study']}”, recordings: {len(roles)}"
    notice = _notice(study["recordings"])
    title = f"{study['title']} (simulated)" if notice else study["title"]
    return Document(title, subtitle, sections, notice).numbered()


def _notice(recordings: Sequence[Mapping[str, Any]]) -> str:
    """Which recordings no arm made, if any."""
    simulated = [recording["name"] for recording in recordings if recording.get("simulate")]
    if not simulated:
        return ""
    some = "all recordings" if len(simulated) == len(recordings) else ", ".join(simulated)
    return f"Simulated: {some} of this study are of the virtual test stand, not of a real arm."


def _results(tables: Mapping[str, pd.DataFrame], figures: Path) -> list[Section]:
    """What each step found: each section with the tables that it shows."""
    parts: dict[str, tuple[Callable[..., list[Block]], str]] = {
        "Closed loop": (closed_loop_blocks, "closed_loop_mae gains published_gains"),
        "Joint torques": (torque_blocks, "torque_mae rotor_inertia parameters"),
        "Accelerations": (motion_blocks, "acceleration_mae imu_calibration innovations"),
        "Friction and currents": (
            current_blocks,
            "friction current_rmse cross_validation payload",
        ),
        "Contact forces": (force_blocks, "force_mae detection"),
    }
    return [
        Section(title, blocks(*(tables[name] for name in names.split()), figures))
        for title, (blocks, names) in parts.items()
    ]


def versions_blocks(commit: str, versions: Mapping[str, str]) -> list[Block]:
    """Which code and which packages made the results."""
    rows = [[Cell(name), Cell(version)] for name, version in versions.items()]
    return [
        Paragraph(f"Made by commit {commit}."),
        Table("Versions of what the numbers depend on.", ["package", "version"], rows),
    ]


def _errata_section(errata: Sequence[Erratum]) -> Section:
    items = [f"{erratum.place}: {erratum.error} Here: {erratum.choice}" for erratum in errata]
    introduction = Paragraph("Errors found in the published work, each with the choice made here.")
    return Section("Errata", [introduction, Items(items, numbered=True)])


def _configuration(study: Mapping[str, Any]) -> list[Block]:
    text = yaml.safe_dump(dict(study), sort_keys=False, allow_unicode=True, default_flow_style=None)
    return [Paragraph("The configuration, with every default filled in:"), Code(text)]

"""The provenance of a study's results as a Workflow Run RO-Crate.

https://w3id.org/ro/wfrun/workflow/0.5
"""

import mimetypes
import os
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rocrate.model import ContextEntity
from rocrate.model.file import File
from rocrate.rocrate import ROCrate

from ur5lib import __version__
from ur5lib.report.results import versions
from ur5lib.tables import checksum
from ur5lib.workspace.origin import commit

CRATE_PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": "Process Run Crate",
    "https://w3id.org/ro/wfrun/workflow/0.5": "Workflow Run Crate",
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": "Workflow RO-Crate",
}
SHA256_TERM = "https://w3id.org/ro/terms/workflow-run#sha256"


def run_crate(
    folder: Path,
    title: str,
    used: Sequence[str],
    results: Sequence[str],
    citation: Mapping[str, Any],
    checksums: Mapping[str, str],
) -> dict[str, Any]:
    """Return the content of ro-crate-metadata.json for the results of one study.

    folder: with configuration.yaml, Snakefile and the results; used: files of devices and of the
    workspace's extensions, which are not copied but identified by checksum; citation: of the
    software, as in CITATION.cff; checksums: SHA-256 of some used files by path, so that these are
    not read again.
    """
    crate = ROCrate(version="1.1")
    crate.metadata.extra_terms["sha256"] = SHA256_TERM
    crate.name, crate.license = title, f"https://spdx.org/licenses/{citation['license']}"
    crate.description = f"Results of the study {folder.name}: {title}"
    crate.root_dataset["conformsTo"] = [
        _context(crate, url, "CreativeWork", name, version=url[-3:])
        for url, name in CRATE_PROFILES.items()
    ]
    workflow = _workflow(crate, folder / "Snakefile", citation)
    read = [_file(crate, folder / "configuration.yaml", "configuration.yaml")]
    for path in used:
        sha256 = checksums.get(path) or checksum(path)
        read.append(_file(crate, Path(path), f"urn:sha256:{sha256}", sha256))
    made = [_file(crate, Path(path), os.path.relpath(path, folder)) for path in results]
    about = {
        "name": f"Run of the study {folder.name}",
        "description": "Snakemake computed the results from the recordings and the settings.",
        "endTime": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    crate.root_dataset["mentions"] = crate.add_action(
        workflow, "#run", object=read, result=made, properties=about
    )
    return dict(crate.metadata.generate())


def _workflow(crate: ROCrate, snakefile: Path, citation: Mapping[str, Any]) -> Any:
    """Add the workflow, with its authors and the software that it ran on."""
    version = f"{__version__}, commit {commit()}"
    about = {"name": citation["title"], "license": crate.license, "version": version}
    workflow = crate.add_workflow(
        snakefile, snakefile.name, main=True, lang="snakemake", properties=about
    )
    workflow["author"] = [
        _context(crate, f"#{author['name']}", "Organization", author["name"])
        for author in citation["authors"]
    ]
    workflow["softwareRequirements"] = [
        _context(crate, f"#{name}", "SoftwareApplication", name, softwareVersion=version)
        for name, version in versions().items()
    ]
    return workflow


def _context(crate: ROCrate, identifier: str, kind: str, name: str, **about: str) -> Any:
    return crate.add(ContextEntity(crate, identifier, {"@type": kind, "name": name, **about}))


def _file(crate: ROCrate, path: Path, identifier: str, sha256: str = "") -> Any:
    """Add a file under an identifier, with its name, format, size [bytes] and checksum.

    sha256: its checksum; empty: it is read from the file.
    """
    about = {
        "name": path.name,
        "contentSize": str(path.stat().st_size),
        "encodingFormat": mimetypes.guess_type(path.name)[0] or "application/octet-stream",
        "sha256": sha256 or checksum(path),
    }
    external = ":" in identifier
    source, place = (identifier, None) if external else (path, identifier)
    return crate.add(File(crate, source, place, properties=about))

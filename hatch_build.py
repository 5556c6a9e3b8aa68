"""A wheel has authors, keywords and address of CITATION.cff, and its commit."""

import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml
from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

STAMP = "ur5lib/workspace/commit.txt"


class Citation(MetadataHookInterface):
    """The package is whose CITATION.cff says it is."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add authors, keywords and, where it has one, the address of the source."""
        cited = yaml.safe_load(Path(self.root, "CITATION.cff").read_text(encoding="utf-8"))
        metadata["authors"] = [{"name": named(one)} for one in cited["authors"]]
        metadata["keywords"] = cited["keywords"]
        metadata["urls"] = {"Source": home} if (home := cited.get("repository-code")) else {}


class Commit(BuildHookInterface):  # type: ignore[type-arg]
    """A wheel that is built in a clone has the commit, as `git archive` writes it for a release."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Stamp a wheel with the commit, "+ changes" where files differ from it."""
        unstamped = Path(self.root, STAMP).read_text(encoding="utf-8").startswith("$")
        if version == "editable" or not unstamped:
            return
        command = ["git", "describe", "--always", "--abbrev=40", "--exclude=*"]
        command += ["--dirty= + changes"]
        try:
            commit = subprocess.check_output(command, cwd=self.root, stderr=subprocess.DEVNULL)
        except (OSError, subprocess.CalledProcessError):
            return
        self.folder = TemporaryDirectory()  # gone with the hook
        stamp = Path(self.folder.name, "commit.txt")
        stamp.write_bytes(commit)
        build_data["force_include"][str(stamp)] = STAMP


def named(author: dict[str, str]) -> str:
    """Return the name of a person or of a group."""
    return author.get("name") or f"{author['given-names']} {author['family-names']}"

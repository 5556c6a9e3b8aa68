"""The place of the workflow: next to the package in a clone, inside an installed package."""

from pathlib import Path

PACKAGE = Path(__file__).parents[1]
_PACKAGED_WORKFLOW = PACKAGE / "workflow"  # pyproject.toml puts it there
IN_CLONE = not _PACKAGED_WORKFLOW.is_dir()
WORKFLOW = PACKAGE.parent if IN_CLONE else _PACKAGED_WORKFLOW  # Snakefile and profiles are there
SNAKEFILE = WORKFLOW / "Snakefile"
CITATION = WORKFLOW / "CITATION.cff"

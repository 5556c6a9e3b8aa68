"""Where the workflow lies: in a clone beside the package, in an installed package inside it."""

from pathlib import Path

PACKAGE = Path(__file__).parents[1]
_INSTALLED = PACKAGE / "workflow"  # pyproject.toml puts it there
IN_CLONE = not _INSTALLED.is_dir()
WORKFLOW = PACKAGE.parent if IN_CLONE else _INSTALLED  # holds Snakefile and profiles
SNAKEFILE = WORKFLOW / "Snakefile"
CITATION = WORKFLOW / "CITATION.cff"
SCRIPTS = WORKFLOW / "workflow" / "scripts"

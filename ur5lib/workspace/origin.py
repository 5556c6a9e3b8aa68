"""Where the code comes from: its name as a distribution, its commit, and the list of packages that
it was tested with.
"""

import hashlib
import subprocess
from importlib.metadata import PackageNotFoundError, version

from ur5lib.workspace.places import IN_CLONE, PACKAGE, WORKFLOW

DISTRIBUTION = "arm-force-lab"  # pyproject.toml
STAMP = PACKAGE / "workspace" / "commit.txt"  # `git archive` writes the commit into it
DIGITS = 12


def commit() -> str:
    """Return the commit of the code, with "+ changes" when the files differ from it.

    In a clone, from git; else from the stamp of a wheel; "(unknown)" without both.
    """
    stamp = STAMP.read_text(encoding="utf-8").strip()
    if not stamp.startswith("$"):
        return stamp[:DIGITS] + stamp[40:]
    if not IN_CLONE:
        return "(unknown)"
    command = ["git", "-C", str(WORKFLOW), "describe", "--always", f"--abbrev={DIGITS}"]
    command += ["--exclude=*", "--dirty= + changes"]
    try:
        name = subprocess.check_output(command, text=True, stderr=subprocess.DEVNULL)
    except (OSError, subprocess.CalledProcessError):
        return "(unknown)"
    return name.strip()


def foreign() -> str:
    """Return a sentence if another distribution holds a package of this name, too, else "".

    pip writes the files of both into one folder, and removes those of both with either.
    """
    try:
        other = version(PACKAGE.name)
    except PackageNotFoundError:
        return ""
    return (
        f"another package is installed as {PACKAGE.name} {other}, and its files lie among these; "
        "install this one into an environment of its own"
    )


def lock() -> str:
    """Return the first digits of the SHA-256 of requirements.lock, the tested packages."""
    return hashlib.sha256((WORKFLOW / "requirements.lock").read_bytes()).hexdigest()[:DIGITS]

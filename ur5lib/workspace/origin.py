"""Where the code comes from: its commit, and the list of packages that it was tested with."""

import hashlib
import subprocess

from ur5lib.workspace.places import IN_CLONE, PACKAGE, WORKFLOW

STAMP = PACKAGE / "workspace" / "commit.txt"  # `git archive` writes the commit into it
DIGITS = 12


def commit() -> str:
    """Return the commit of the code, with "+ changes" when the files differ from it.

    In a clone, from git; else from the stamp of a release; "(unknown)" without both.
    """
    stamp = STAMP.read_text(encoding="utf-8").strip()
    if not stamp.startswith("$"):
        return stamp[:DIGITS]
    if not IN_CLONE:
        return "(unknown)"
    command = ["git", "-C", str(WORKFLOW), "describe", "--always", f"--abbrev={DIGITS}"]
    command += ["--exclude=*", "--dirty= + changes"]
    try:
        name = subprocess.check_output(command, text=True, stderr=subprocess.DEVNULL)
    except (OSError, subprocess.CalledProcessError):
        return "(unknown)"
    return name.strip()


def lock() -> str:
    """Return the first digits of the SHA-256 of requirements.lock, the tested packages."""
    return hashlib.sha256((WORKFLOW / "requirements.lock").read_bytes()).hexdigest()[:DIGITS]

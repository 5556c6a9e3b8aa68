"""Versions of the code and of the packages on which the numbers depend."""

import platform
import subprocess
from importlib import metadata

PACKAGES = ["snakemake", "numpy", "scipy", "pandas", "pyarrow"]
PACKAGES += ["torch", "pytorch-kinematics", "mujoco", "matplotlib", "typst"]


def versions() -> dict[str, str]:
    """Return the versions of the software on which the numbers depend."""
    return {"Python": platform.python_version()} | {
        name: metadata.version(name) for name in PACKAGES
    }


def commit() -> str:
    """Return the commit of the code, with "+ changes" when the files differ from it."""
    try:
        name = subprocess.check_output(
            ["git", "describe", "--always", "--abbrev=12", "--dirty= + changes"],
            text=True,
            stderr=subprocess.DEVNULL,
        )
    except (OSError, subprocess.CalledProcessError):
        return "(unknown)"
    return name.strip()

"""Snakemake in a process that has loaded it already, which takes longer than most plans do."""

import multiprocessing
import os
import pkgutil
import subprocess
import sys
import tempfile
from pathlib import Path

WARM = multiprocessing.get_context("forkserver")  # a process that waits, and forks one for each run
PLUGINS = [one.name for one in pkgutil.iter_modules() if one.name.startswith("snakemake_")]
WARM.set_forkserver_preload(["snakemake.cli", "pydantic", *PLUGINS])


def run(
    folder: Path, environment: dict[str, str], arguments: tuple[str, ...]
) -> subprocess.CompletedProcess[str]:
    """What `python -m snakemake` with arguments prints in a folder, and how it ends."""
    with tempfile.NamedTemporaryFile("r") as printed:
        given = folder, environment, arguments, printed.name
        process = WARM.Process(target=snakemake, args=given)
        process.start()
        try:
            process.join()
        finally:
            process.kill()
        assert process.exitcode is not None
        return subprocess.CompletedProcess(arguments, process.exitcode, printed.read())


def snakemake(
    folder: Path, environment: dict[str, str], arguments: tuple[str, ...], printed: str
) -> None:
    """Be Snakemake: in a folder, with its modules and an environment, printing to a file."""
    os.chdir(folder)
    os.environ.update(environment)
    sys.path.insert(0, str(folder))
    sys.dont_write_bytecode = "PYTHONDONTWRITEBYTECODE" in environment
    with open(printed, "w") as file:
        os.dup2(file.fileno(), sys.stdout.fileno())
        os.dup2(file.fileno(), sys.stderr.fileno())
    from snakemake.cli import main

    main([*arguments])

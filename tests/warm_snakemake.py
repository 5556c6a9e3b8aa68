"""Snakemake in a process that has loaded it already, which takes longer than most plans do.

So have the packages of the steps been loaded, for the first worker of a run.
"""

import gc
import multiprocessing
import os
import pkgutil
import subprocess
import sys
import tempfile
from multiprocessing.context import ForkServerProcess
from pathlib import Path
from typing import Any

WARM = multiprocessing.get_context("forkserver")  # a process that waits, and forks one for each run
PLUGINS = [one.name for one in pkgutil.iter_modules() if one.name.startswith("snakemake_")]
OF_STEPS = ["matplotlib.pyplot", "mujoco", "pandas", "pyarrow.parquet", "pytorch_kinematics"]
OF_STEPS += ["scipy.interpolate", "scipy.ndimage", "scipy.optimize", "scipy.signal", "scipy.stats"]
WARM.set_forkserver_preload(["snakemake.cli", "pydantic", *PLUGINS, *OF_STEPS])
os.environ["OMP_NUM_THREADS"] = "1"  # as of each worker


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


def start(folder: Path, environment: dict[str, str]) -> ForkServerProcess:
    """Such a run in a session of its own, which prints nothing."""
    process = WARM.Process(target=in_own_session, args=(folder, environment, (), os.devnull))
    process.start()
    return process


def in_own_session(*given: Any) -> None:
    os.setsid()
    snakemake(*given)


def snakemake(
    folder: Path, environment: dict[str, str], arguments: tuple[str, ...], printed: str
) -> None:
    """Be Snakemake: in a folder, with its modules and an environment, printing to a file."""
    gc.freeze()  # what was loaded stays: to look for garbage in it takes a quarter of a plan
    os.chdir(folder)
    os.environ.update(environment)
    sys.path.insert(0, str(folder))
    with open(printed, "w") as file:
        os.dup2(file.fileno(), sys.stdout.fileno())
        os.dup2(file.fileno(), sys.stderr.fileno())
    from snakemake.cli import main

    if "--dry-run" not in arguments:
        fork_worker()
    main([*arguments])


def fork_worker() -> None:
    """Fork a worker, which a run finds idle."""
    from ur5lib.jobs.workers import IDLE, Worker, serve

    worker = Worker.__new__(Worker)
    worker.connection, other = multiprocessing.Pipe()
    if os.fork() == 0:
        worker.connection.close()
        serve(other)
        os._exit(0)
    other.close()
    IDLE.put(worker)

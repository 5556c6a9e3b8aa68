"""Snakemake, and `ur5`, in processes that have loaded their packages already, which takes longer
than most plans and answers do.

So have the packages of the steps been loaded, for the first worker of a run.
"""

import gc
import multiprocessing
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from multiprocessing.context import ForkServerProcess
from pathlib import Path
from typing import Any

WARM = multiprocessing.get_context("forkserver")  # a process that waits, and forks one for each run
OF_STEPS = ["matplotlib.pyplot", "mujoco", "pandas", "pyarrow.parquet", "pytorch_kinematics"]
OF_STEPS += ["scipy.interpolate", "scipy.ndimage", "scipy.optimize", "scipy.signal", "scipy.stats"]
WARM.set_forkserver_preload(["tests.warm_plugins", "pydantic", *OF_STEPS])
os.environ["OMP_NUM_THREADS"] = "1"  # as of each worker


def run(
    folder: Path, environment: dict[str, str], arguments: tuple[str, ...]
) -> subprocess.CompletedProcess[str]:
    """What `python -m snakemake` with arguments prints in a folder, and how it ends."""
    with tempfile.NamedTemporaryFile("r") as printed:
        status = ended(snakemake, folder, environment, arguments, printed.name)
        return subprocess.CompletedProcess(arguments, status, printed.read())


def run_ur5(
    folder: Path, environment: dict[str, str], arguments: tuple[str, ...]
) -> subprocess.CompletedProcess[str]:
    """What `ur5` with arguments prints in a folder, and how it ends."""
    with tempfile.NamedTemporaryFile("r") as out, tempfile.NamedTemporaryFile("r") as err:
        status = ended(ur5, folder, environment, arguments, out.name, err.name)
        return subprocess.CompletedProcess(arguments, status, out.read(), err.read())


def ended(target: Callable[..., None], *given: Any) -> int:
    """How a function ends in a process of its own."""
    process = WARM.Process(target=target, args=given)
    process.start()
    try:
        process.join()
    finally:
        process.kill()
    assert process.exitcode is not None
    return process.exitcode


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
    settle(folder, environment, printed, printed)
    from snakemake.cli import main

    if "--dry-run" not in arguments:
        fork_worker()
    main([*arguments])


def ur5(
    folder: Path, environment: dict[str, str], arguments: tuple[str, ...], out: str, err: str
) -> None:
    """Be `ur5`: in a folder, with the modules of an environment, printing to two files."""
    settle(folder, environment, out, err)
    sys.argv = ["ur5", *arguments]
    from ur5lib.cli import main

    main()


def settle(folder: Path, environment: dict[str, str], out: str, err: str) -> None:
    """Go to a folder, with its modules and those of an environment, and print to files."""
    gc.freeze()  # what was loaded stays: to look for garbage in it takes a quarter of a plan
    os.chdir(folder)
    os.environ.update(environment)
    sys.path[:0] = [str(folder), *environment["PYTHONPATH"].split(os.pathsep)]
    for path, stream in ((out, sys.stdout), (err, sys.stderr)):
        with open(path, "a") as file:
            os.dup2(file.fileno(), stream.fileno())


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

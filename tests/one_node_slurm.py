"""A Slurm cluster of one node on this machine, for as long as a block or a command runs.

    python tests/one_node_slurm.py sinfo

It needs Debian's slurm-wlm and munge, and root. All of it is in one temporary folder, listens on
127.0.0.1 alone, and is gone at the end.
"""

import os
import pwd
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "setpriv")
CONFIGURATION = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket,cred_expire=5
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerParameters=batch_sched_delay=0,sched_min_interval=100000
KillWait=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory={memory} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class NoSlurmError(Exception):
    """Slurm cannot run here; the message says why."""


@contextmanager
def one_node_slurm(cores: int = 2, start_up_s: float = 30.0) -> Iterator[dict[str, str]]:
    """Run Slurm on this machine; give the environment in which its commands find it.

    cores: how many the node has, whatever the machine has; start_up_s: how long it may take to
    answer [s]. Raises NoSlurmError.
    """
    if reason := why_not():
        raise NoSlurmError(reason)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="slurm-")))
        folder.chmod(0o755)  # munge's own user passes through it
        environment = os.environ | {"SLURM_CONF": str(write_files(folder, cores))}
        daemons: dict[str, subprocess.Popen[bytes]] = {}
        stack.callback(stop, daemons, environment)
        for name, command in commands(folder).items():
            log = stack.enter_context((folder / f"{name}.log").open("wb"))
            daemons[name] = subprocess.Popen(
                ["setpriv", "--pdeathsig", "TERM", *command],  # it ends with this process, too
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
            )
            if name == "munged":
                wait_for((folder / "munge" / "socket").exists, daemons, folder, start_up_s)
        wait_for(lambda: answers(environment), daemons, folder, start_up_s)
        yield environment


def why_not() -> str:
    """Return why Slurm cannot run here; empty if it can."""
    missing = [name for name in PROGRAMS if shutil.which(name) is None]
    if missing:
        return f"{', '.join(missing)} not found: `apt-get install slurm-wlm munge`"
    return "" if os.geteuid() == 0 else "Slurm's daemons need root"


def write_files(folder: Path, cores: int) -> Path:
    """Write what the daemons need below a folder; return Slurm's configuration."""
    for name in ("munge", "state", "spool"):
        (folder / name).mkdir(mode=0o755)
    key = folder / "munge" / "key"
    key.write_bytes(os.urandom(128))
    key.chmod(0o600)
    user = pwd.getpwnam("munge")
    for path in (key, key.parent):
        os.chown(path, user.pw_uid, user.pw_gid)
    controller_port, node_port = free_ports(2)
    configuration = folder / "slurm.conf"
    configuration.write_text(
        CONFIGURATION.format(
            host=socket.gethostname().split(".")[0],
            folder=folder,
            cores=cores,
            memory=os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2**20,
            controller_port=controller_port,
            node_port=node_port,
        )
    )
    return configuration


def free_ports(count: int) -> list[int]:
    """Return ports of 127.0.0.1 on which nothing listens."""
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


def commands(folder: Path) -> dict[str, list[str]]:
    """Return the daemons' command lines, in the order in which they start."""
    munge = folder / "munge"
    return {
        "munged": [
            *("--reuid=munge", "--regid=munge", "--clear-groups", "munged", "--foreground"),
            *(f"--socket={munge}/socket", f"--key-file={munge}/key", f"--seed-file={munge}/seed"),
            *(f"--pid-file={munge}/pid", f"--log-file={munge}/log"),
        ],
        "slurmctld": ["slurmctld", "-D", "-i"],
        "slurmd": ["slurmd", "-D"],
    }


def wait_for(
    happens: Callable[[], bool],
    daemons: dict[str, subprocess.Popen[bytes]],
    folder: Path,
    limit_s: float,
) -> None:
    """Wait until something happens; raise NoSlurmError if a daemon ends or it takes too long."""
    ends = time.monotonic() + limit_s
    while not happens():
        for name, process in daemons.items():
            if process.poll() is not None:
                said = (folder / f"{name}.log").read_text(errors="replace").strip()
                raise NoSlurmError(f"{name} ended: {said.splitlines()[-1] if said else 'silent'}")
        if time.monotonic() > ends:
            raise NoSlurmError(f"Slurm did not answer within {limit_s:.0f} s")
        time.sleep(0.1)


def answers(environment: dict[str, str]) -> bool:
    """Whether the node is ready for jobs."""
    return ask(environment, "sinfo", "--noheader", "--format=%T") == "idle"


def ask(environment: dict[str, str], *command: str) -> str:
    """Return what a command of Slurm prints; empty if it says nothing within 10 s."""
    with suppress(subprocess.TimeoutExpired):
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, check=False, timeout=10
        )
        return done.stdout.strip()
    return ""


def stop(daemons: dict[str, subprocess.Popen[bytes]], environment: dict[str, str]) -> None:
    """Cancel all jobs, then end the daemons, the last first."""
    if "slurmd" in daemons:
        ask(environment, "scancel", "--state=PENDING", f"--user={os.getuid()}")
        ask(environment, "scancel", f"--user={os.getuid()}")
        ends = time.monotonic() + 10
        while ask(environment, "squeue", "--noheader") and time.monotonic() < ends:
            time.sleep(0.2)
    for process in reversed(daemons.values()):
        process.terminate()
        with suppress(subprocess.TimeoutExpired):
            process.wait(timeout=5)
        process.kill()
        process.wait()


def main() -> None:
    """Run a command with Slurm at hand."""
    try:
        with one_node_slurm() as environment:
            sys.exit(subprocess.run(sys.argv[1:], env=environment, check=False).returncode)
    except NoSlurmError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()

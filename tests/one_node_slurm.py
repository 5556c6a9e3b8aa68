"""A Slurm cluster of one node on this machine, for as long as a block runs.

It needs Debian's slurm-wlm and munge, and root. All of it is in one temporary folder, listens on
127.0.0.1 alone, and is gone at the end.
"""

import os
import pwd
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

CORES = 2  # of the node, whatever the machine has
START_UP_S = 30.0  # that a daemon may take to answer
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


IS_READY = ("sinfo", "--noheader", "--format=%T")


class NoSlurmError(Exception):
    """Slurm cannot run here; the message says why."""


@contextmanager
def one_node_slurm() -> Iterator[dict[str, str]]:
    """Run Slurm on this machine; give the environment in which its commands find it.

    Raises NoSlurmError.
    """
    if missing := [name for name in PROGRAMS if shutil.which(name) is None]:
        raise NoSlurmError(f"{', '.join(missing)} not found: `apt-get install slurm-wlm munge`")
    if os.geteuid() != 0:
        raise NoSlurmError("Slurm's daemons need root")
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="slurm-")))
        folder.chmod(0o755)  # munge's own user passes through it
        environment = os.environ | {"SLURM_CONF": str(write_files(folder))}
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
                wait_for((folder / "munge" / "socket").exists, daemons, folder)
        wait_for(lambda: ask(environment, *IS_READY) == "idle", daemons, folder)
        yield environment


def write_files(folder: Path) -> Path:
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
            cores=CORES,
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
) -> None:
    """Wait until something happens; raise NoSlurmError if a daemon ends or it takes too long."""
    ends = time.monotonic() + START_UP_S
    while not happens():
        for name, process in daemons.items():
            if process.poll() is not None:
                said = (folder / f"{name}.log").read_text(errors="replace").strip()
                raise NoSlurmError(f"{name} ended: {said.splitlines()[-1] if said else 'silent'}")
        if time.monotonic() > ends:
            raise NoSlurmError(f"Slurm did not answer within {START_UP_S:.0f} s")
        time.sleep(0.1)


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

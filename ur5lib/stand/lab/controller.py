"""An emulated controller of a Universal Robots arm, in a process of its own.

RTDE, the realtime port, the dashboard and the script ports answer on 127.0.0.1, as ur_rtde's
clients and plain sockets expect them; behind them the simulated arm moves in real time.
"""

import asyncio
import contextlib
import multiprocessing
import selectors
import signal
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Self

import numpy as np

from ur5lib.errors import InputError
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.stand.lab.control_box import ControlBox
from ur5lib.stand.lab.dashboard_server import DashboardClient
from ur5lib.stand.lab.live_arm import LiveArm
from ur5lib.stand.lab.realtime_server import RealtimeServer
from ur5lib.stand.lab.rtde_server import RtdeServer
from ur5lib.stand.lab.script_port import ScriptClient
from ur5lib.stand.lab.stream_faults import StreamFaults
from ur5lib.stand.lab.truth import Truth
from ur5lib.stand.plan import Contact, SimulatedRecording, Standstill
from ur5lib.timeseries.arrays import Array

HOST = "127.0.0.1"
STARTS = 60.0  # s within which the process of a controller must answer
STILL = SimulatedRecording(trajectory=Standstill(kind="standstill"))


@dataclass(frozen=True)
class Ports:
    """The ports of a controller; ur_rtde's interfaces know only these defaults."""

    rtde: int = 30004
    realtime: int = 30003
    secondary: int = 30002
    dashboard: int = 29999

    @classmethod
    def free(cls) -> Self:
        """Return four unused ports, for clients whose ports can be set."""
        with contextlib.ExitStack() as stack:
            sockets = [stack.enter_context(socket.socket()) for _ in range(4)]
            for free in sockets:
                free.bind((HOST, 0))
            return cls(*(free.getsockname()[1] for free in sockets))


@dataclass(frozen=True)
class Generation:
    """A generation of controllers: software, rate [Hz], size of port 30003's messages [bytes]."""

    software: tuple[int, int, int, int]
    rate: int
    message: int


CB3 = Generation((3, 15, 8, 106339), 125, 1140)
E_SERIES = Generation((5, 11, 1, 108318), 500, 1220)


@dataclass(frozen=True)
class ControllerClock:
    """The controller's clock: host = start + (1 + drift) (stamp − uptime), all in [s].

    host: time.monotonic; stamp: the controller's `timestamp`; uptime: its value at the start.
    """

    start: float
    uptime: float
    drift: float

    def host(self, stamp: Array | float) -> Array | float:
        """Return the host's time of the controller's timestamps."""
        return self.start + (1 + self.drift) * (stamp - self.uptime)

    def stamp(self, host: float) -> float:
        """Return the controller's timestamp at a time of the host [s]."""
        return self.uptime + (host - self.start) / (1 + self.drift)


@dataclass(frozen=True)
class Setup:
    """The settings of an emulated controller.

    plan: payload, temperatures, contacts and sensors of the arm, which starts at rest where the
    plan's trajectory starts; rate: [Hz], of its cycle; message: size of port 30003's messages
    [bytes]; uptime: [s], at the start; drift_ppm: of its clock, positive: slow; seed: of the noise.
    """

    robot: Robot
    plan: SimulatedRecording
    rate: int
    software: tuple[int, int, int, int]
    message: int
    ports: Ports = Ports()
    faults: StreamFaults = StreamFaults()
    uptime: float = 4096.0
    drift_ppm: float = 0.0
    seed: int = 0


class EmulatedController:
    """A running emulated controller: `with EmulatedController("ur5e", rate=500) as controller:`.

    truth: the true motion and forces; clock: the controller's. Raises InputError when a port is
    taken.
    """

    def __init__(
        self,
        robot: str | Robot = "ur5e",
        rate: int | None = None,
        plan: SimulatedRecording = STILL,
        **options: Any,
    ) -> None:
        """robot: or its name; rate: [Hz], None for that of its generation; options: see Setup."""
        arm = load_robot(robot_path(robot)) if isinstance(robot, str) else robot
        generation = E_SERIES if arm.wrist_sensor else CB3
        setup = Setup(arm, plan, rate or generation.rate, generation.software, generation.message)
        self.setup = replace(setup, **options)

    def __enter__(self) -> Self:
        """Start; returns when all ports are open and the clock runs."""
        self.truth = Truth.new()
        context = multiprocessing.get_context("spawn")
        self._line, far_end = context.Pipe()
        self._process = context.Process(
            target=_run, args=(self.setup, self.truth, far_end), daemon=True
        )
        self._process.start()
        far_end.close()
        start = self._answer(STARTS)
        self.clock = ControllerClock(start, self.setup.uptime, 1e-6 * self.setup.drift_ppm)
        return self

    def __exit__(self, *_: object) -> None:
        """Stop at once."""
        self._process.kill()
        self._process.join()
        self._line.close()
        Path(self.truth.path).unlink(missing_ok=True)

    def touch(self, contact: Contact) -> None:
        """Add a contact with the arm; its start counts from the controller's start."""
        self._ask("touch", contact)

    def time(self) -> float:
        """Return the time since the start, by the controller's clock [s]."""
        return float(self._ask("time"))

    def protective_stop(self) -> None:
        """Stop the arm as a collision would."""
        self._ask("protective_stop")

    def unlock(self) -> bool:
        """Release a protective stop, unless the arm still brakes; return whether it is released."""
        return bool(self._ask("unlock"))

    def die(self) -> None:
        """Close all connections and ports, as when the power fails; the arm stands still."""
        self._ask("die")

    def come_back(self) -> None:
        """Open the ports again."""
        self._ask("come_back")

    def freeze(self, frozen: bool = True) -> None:
        """Keep the connections and send nothing; False: send again."""
        self._ask("freeze", frozen)

    def _ask(self, order: str, *arguments: Any) -> Any:
        self._line.send((order, *arguments))
        return self._answer(STARTS)

    def _answer(self, patience: float) -> Any:
        if not self._line.poll(patience):
            raise TimeoutError(f"the emulated controller does not answer within {patience:g} s")
        answer = self._line.recv()
        if isinstance(answer, InputError):
            self.__exit__()
            raise answer
        return answer


def _run(setup: Setup, truth: Truth, line: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that holds it
    # `select` wakes within microseconds of the set time, `epoll` within 1 ms.
    loop = asyncio.SelectorEventLoop(selectors.SelectSelector())
    loop.run_until_complete(_Controller(setup, truth, line).run())


class _Controller:
    """The controller within its process."""

    def __init__(self, setup: Setup, truth: Truth, line: Connection) -> None:
        self._setup, self._truth, self._line = setup, truth, line
        random = np.random.default_rng(setup.seed).spawn(4)
        arm = LiveArm(setup.robot, setup.plan, truth, random[0])
        self._box = ControlBox(arm, setup.software, 1 / setup.rate, setup.uptime, random[1])
        self._rtde = RtdeServer(self._box, setup.faults, random[2])
        self._realtime = RealtimeServer(self._box, setup.message, setup.faults, random[3])
        self._servers: list[asyncio.Server] = []
        self._frozen = False

    async def run(self) -> None:
        """Run until the process that holds the other end of the line is gone."""
        loop = asyncio.get_running_loop()
        gone = loop.create_future()
        try:
            await self._open()
        except InputError as error:
            self._line.send(error)
            return
        start = time.monotonic()
        self._truth.begin(start, 1 + 1e-6 * self._setup.drift_ppm)
        self._line.send(start)
        loop.add_reader(self._line.fileno(), self._obey, gone)
        pace = loop.create_task(self._pace(start))
        await asyncio.wait({gone, pace}, return_when=asyncio.FIRST_COMPLETED)
        if pace.done():
            pace.result()  # raises the error that ended it

    async def _pace(self, start: float) -> None:
        """Publish each cycle when its time has come, then compute the next one."""
        period = (1 + 1e-6 * self._setup.drift_ppm) * self._box.cycle
        cycle = 0
        while True:
            await asyncio.sleep(max(0.0, start + cycle * period - time.monotonic()))
            if not self._frozen:
                self._rtde.publish(cycle)
                self._realtime.publish()
            self._box.advance()
            cycle += 1

    async def _open(self) -> None:
        ports, box = self._setup.ports, self._box
        services: dict[int, Callable[[], asyncio.Protocol]] = {
            ports.rtde: self._rtde.connect,
            ports.realtime: self._realtime.connect,
            ports.secondary: lambda: ScriptClient(box),
            ports.dashboard: lambda: DashboardClient(box),
        }
        loop = asyncio.get_running_loop()
        for port, service in services.items():
            try:
                self._servers.append(await loop.create_server(service, HOST, port))
            except OSError as error:
                raise InputError(
                    f"port {port} of {HOST} is taken: is another emulated controller running?"
                ) from error

    def _obey(self, gone: "asyncio.Future[None]") -> None:
        try:
            order, *arguments = self._line.recv()
        except (EOFError, OSError):
            gone.set_result(None)
            return
        asyncio.get_running_loop().create_task(self._carry_out(order, arguments))

    async def _carry_out(self, order: str, arguments: list[Any]) -> None:
        answer: Any = None
        match order:
            case "touch":
                self._box.arm.touch(*arguments)
            case "time":
                answer = self._box.time
            case "protective_stop":
                self._box.protective_stop("collision")
            case "unlock":
                answer = self._box.unlock()
            case "die":
                self._die()
            case "come_back":
                await self._open()
            case "freeze":
                (self._frozen,) = arguments
        self._line.send(answer)

    def _die(self) -> None:
        self._box.stop()
        for server in self._servers:
            server.close()
        self._servers.clear()
        for connection in set(self._box.connections):
            connection.abort()

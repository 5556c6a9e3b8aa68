"""The double of a Universal Robots arm's controller, in a process of its own.

RTDE, the realtime port, the dashboard and the script ports answer on 127.0.0.1, as ur_rtde's
clients and plain sockets expect them; behind them the simulated arm moves in real time.
"""

import asyncio
import contextlib
import inspect
import multiprocessing
import selectors
import signal
import socket
import struct
import tempfile
import time
from asyncio import StreamReader, StreamWriter
from collections.abc import Callable, Coroutine
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, Self

import numpy as np

from ur5lab.doubles import dashboard_server
from ur5lab.doubles.control_box import ControlBox
from ur5lab.doubles.control_script import run_programs
from ur5lab.doubles.device_double import HOST, DeviceClock
from ur5lab.doubles.live_arm import LiveArm
from ur5lab.doubles.streams import RealtimeServer, RtdeServer
from ur5lab.doubles.transmission import TransmissionFaults
from ur5lab.doubles.true_states import TrueStates
from ur5lib.commands.processes import end_with_parent
from ur5lib.errors import InputError
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.stand.plan import SimulatedRecording, Standstill

ANSWER_TIMEOUT = 60.0  # s; the process of a controller must answer in this time
MAX_LINE_BYTES = 1 << 24  # a client sends at most this many a line
STANDSTILL_PLAN = SimulatedRecording(trajectory=Standstill(kind="standstill"))


@dataclass(frozen=True)
class Ports:
    """The ports of a controller's interfaces; the defaults are the only ones that ur_rtde's
    interfaces know.
    """

    rtde: int = 30004
    realtime: int = 30003
    secondary: int = 30002
    dashboard: int = 29999

    @classmethod
    def free(cls) -> Self:
        """Return four unused ports, for clients with ports that can be set."""
        with contextlib.ExitStack() as stack:
            sockets = [stack.enter_context(socket.socket()) for _ in range(4)]
            for free in sockets:
                free.bind((HOST, 0))
            return cls(*(free.getsockname()[1] for free in sockets))


class Generation(NamedTuple):
    """What controllers of one generation have in common, as in `ControllerSetup`."""

    software: tuple[int, int, int, int]
    rate: int
    message: int


CB3 = Generation(software=(3, 15, 8, 106339), rate=125, message=1140)
E_SERIES = Generation(software=(5, 11, 1, 108318), rate=500, message=1220)

Service = Callable[[StreamReader, StreamWriter], Coroutine[Any, Any, None]]


@dataclass(frozen=True)
class ControllerSetup:
    """The settings of a controller's double.

    plan: payload, temperatures, contacts and sensors of the arm, which starts at rest where the
    plan's trajectory starts; software: major, minor, bugfix, build; rate: [Hz], of its cycle;
    message: size of port 30003's messages [bytes]; seed: of the noise.
    """

    robot: Robot
    plan: SimulatedRecording
    software: tuple[int, int, int, int]
    rate: int
    message: int
    ports: Ports = Ports()
    faults: TransmissionFaults = TransmissionFaults()
    clock: DeviceClock = DeviceClock(offset_s=4096.0)
    seed: int = 0


class ControllerDouble:
    """A running double of a controller: `with ControllerDouble("ur5e", rate=500) as controller:`.

    truth: the true motion and forces; clock: the controller's. Raises InputError when a port is
    taken.
    """

    def __init__(
        self,
        robot: str | Robot = "ur5e",
        plan: SimulatedRecording = STANDSTILL_PLAN,
        **options: Any,
    ) -> None:
        """Take the settings; robot: an arm or its name; options: of ControllerSetup, by default of
        the arm's generation.
        """
        arm = load_robot(robot_path(robot)) if isinstance(robot, str) else robot
        generation = E_SERIES if arm.wrist_sensor else CB3
        self.setup = ControllerSetup(arm, plan, **generation._asdict() | options)

    def __enter__(self) -> Self:
        """Start the controller; return when all ports are open and the clock runs."""
        self._folder = tempfile.TemporaryDirectory()
        states = Path(self._folder.name, "states")
        context = multiprocessing.get_context("spawn")
        self._line, far_end = context.Pipe()
        self._process = context.Process(
            target=_run, args=(self.setup, states, far_end), daemon=True
        )
        self._process.start()
        far_end.close()
        self.clock = replace(self.setup.clock, start=self._answer())
        self.truth = TrueStates(states, self.clock)
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the controller at once."""
        self._process.kill()
        self._process.join()
        self._line.close()
        self._folder.cleanup()

    def ask(self, order: str, *arguments: Any) -> Any:
        """Give the controller an order by its name in `_ControllerProcess.orders`, and return its
        answer.
        """
        self._line.send((order, *arguments))
        return self._answer()

    def _answer(self) -> Any:
        if not self._line.poll(ANSWER_TIMEOUT):
            raise TimeoutError(
                f"the double of the controller does not answer within {ANSWER_TIMEOUT:g} s"
            )
        answer = self._line.recv()
        if isinstance(answer, InputError):
            self.__exit__()
            raise answer
        return answer


def _run(setup: ControllerSetup, states: Path, line: Connection) -> None:
    end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that started it
    # `select` wakes within microseconds of the set time, `epoll` within 1 ms.
    loop = asyncio.SelectorEventLoop(selectors.SelectSelector())
    with states.open("wb") as truth:
        loop.run_until_complete(_ControllerProcess(setup, truth, line).run())


class _ControllerProcess:
    """The controller as it runs in the process of its own."""

    def __init__(self, setup: ControllerSetup, truth: BinaryIO, line: Connection) -> None:
        self._setup, self._line = setup, line
        random = np.random.default_rng(setup.seed).spawn(2)
        arm = LiveArm(setup.robot, setup.plan, truth, random[0])
        software, uptime = setup.software, setup.clock.offset_s
        self._box = box = ControlBox(arm, software, 1 / setup.rate, uptime, random[1])
        self._rtde = RtdeServer(box, setup.faults)
        self._realtime = RealtimeServer(box, setup.message, setup.faults)
        self._servers: list[asyncio.Server] = []
        self._clients: set[StreamWriter] = set()
        self._frozen = False
        self.orders: dict[str, Callable[..., Any]] = {
            "touch": arm.touch,  # add a contact, with its start counted from the controller's start
            "time": lambda: box.time,  # since the start, by the controller's clock [s]
            "stop": lambda: box.protective_stop("collision"),
            "die": self._die,  # as when the power fails; the arm stops
            "come back": self._open,
            "freeze": self._freeze,  # True: keep the connections and send nothing
        }

    async def run(self) -> None:
        """Run until the process that started it is gone."""
        loop = asyncio.get_running_loop()
        gone = loop.create_future()
        try:
            await self._open()
        except InputError as error:
            self._line.send(error)
            return
        clock = self._setup.clock.begun()
        self._line.send(clock.start)
        loop.add_reader(self._line.fileno(), self._obey, gone)
        pace = loop.create_task(self._pace(clock))
        await asyncio.wait({gone, pace}, return_when=asyncio.FIRST_COMPLETED)
        if pace.done():
            pace.result()  # raises the error that ended it

    async def _pace(self, clock: DeviceClock) -> None:
        """Publish each cycle when its time has come, then compute the next one."""
        cycle = 0
        while True:
            due = clock.start + clock.scale * cycle * self._box.cycle
            await asyncio.sleep(max(0.0, due - time.monotonic()))
            if not self._frozen:
                self._rtde.publish(cycle)
                self._realtime.publish()
            self._box.advance()
            cycle += 1

    async def _open(self) -> None:
        """Open the ports."""
        ports, box = self._setup.ports, self._box
        services: dict[int, Service] = {
            ports.rtde: self._rtde.serve,
            ports.realtime: self._realtime.serve,
            ports.secondary: lambda reader, _: run_programs(box, reader),
            ports.dashboard: partial(dashboard_server.serve, box),
        }
        for port, service in services.items():
            client = partial(self._serve, service)
            try:
                server = await asyncio.start_server(client, HOST, port, limit=MAX_LINE_BYTES)
            except OSError as error:
                raise InputError(
                    f"port {port} of {HOST} is taken: is another controller or its double running?"
                ) from error
            self._servers.append(server)

    async def _serve(self, service: Service, reader: StreamReader, writer: StreamWriter) -> None:
        """Serve a client until it hangs up, or sends an impossible package, line or name."""
        self._clients.add(writer)
        with contextlib.suppress(OSError, EOFError, ValueError, OverflowError, struct.error):
            await service(reader, writer)
        self._clients.discard(writer)
        writer.close()

    def _obey(self, gone: "asyncio.Future[None]") -> None:
        try:
            order, *arguments = self._line.recv()
        except (EOFError, OSError):
            gone.set_result(None)
            return
        asyncio.get_running_loop().create_task(self._carry_out(order, arguments))

    async def _carry_out(self, order: str, arguments: list[Any]) -> None:
        answer = self.orders[order](*arguments)
        self._line.send(await answer if inspect.isawaitable(answer) else answer)

    def _freeze(self, frozen: bool) -> None:
        self._frozen = frozen

    def _die(self) -> None:
        """Close all connections and ports, as when the power fails."""
        self._box.stop()
        for server in self._servers:
            server.close()
        self._servers.clear()
        for client in self._clients:
            client.transport.abort()

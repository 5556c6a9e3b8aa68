"""ATI Net F/T: a force and torque sensor with a box in the network, as a device to record.

The box sends its records by Raw Data Transfer (RDT) over UDP, one a datagram, and without a
checksum besides UDP's. Source: ATI Industrial Automation, Net F/T manual 9620-05-NET FT, "UDP
Interface Using RDT" and "System Status Code". All numbers are big-endian.
"""

import contextlib
import math
import socket
import struct
import time
from typing import Final
from xml.etree import ElementTree

import numpy as np
import requests

from ur5lab.recorder.device import (
    ANSWER_TIMEOUT,
    GATHERING_TIME,
    Counter,
    DeviceLost,
    Identity,
    NewSamples,
    Silence,
)
from ur5lib.channels import units_of
from ur5lib.errors import InputError

PORT = 49152
MAX_RECORD_RATE = 8000.0  # Hz; Net F/T boxes send up to 7000 records a second, Axia sensors 7812
SEQUENCE_BITS = 32
REQUEST_HEADER = 0x1234
STOP, STREAM, SET_BIAS = 0x0000, 0x0002, 0x0042  # commands; STREAM: one record per datagram
SATURATION_BIT, ERROR_BIT = 1 << 17, 1 << 31  # bits of the status: gauges saturated; any error
COUNTER_COLUMNS: Final = ("rdt_sequence", "ft_sequence", "status")  # before the six counts
REQUEST = struct.Struct(">HHI")
RECORD = struct.Struct(">3I6i")

UNITS = units_of("ft_f", "ft_t")
FORCE_UNITS = {  # N; names as in netftapi2.xml, in lower case and without hyphens
    "n": 1.0,
    "kn": 1e3,
    "lbf": 4.4482216152605,
    "klbf": 4448.2216152605,
    "kgf": 9.80665,
    "gf": 9.80665e-3,
    "g": 9.80665e-3,
}
TORQUE_UNITS = {  # Nm
    "nm": 1.0,
    "nmm": 1e-3,
    "knm": 1e3,
    "lbfin": 4.4482216152605 * 0.0254,
    "lbfft": 4.4482216152605 * 0.3048,
    "kgfcm": 9.80665e-2,
}
REQUEST_ATTEMPTS = 4  # for the stream, since UDP may lose requests
MAX_PAGE_BYTES = 1 << 20  # bytes
RECEIVE_BUFFER_BYTES = (
    1 << 22
)  # bytes of datagrams that the socket may queue; Linux may allow fewer


def request(command: int) -> bytes:
    """Return the bytes of a request. Its count of records is 0: STREAM sends until STOP."""
    return REQUEST.pack(REQUEST_HEADER, command, 0)


def decode(datagram: bytes) -> tuple[int, ...] | None:
    """Return the nine numbers of a record; None for a datagram of another size.

    COUNTER_COLUMNS are first; the last six are counts of Fx, Fy, Fz, Tx, Ty, Tz.
    """
    return RECORD.unpack(datagram) if len(datagram) == RECORD.size else None


class NetFT:
    """The force sensor at an address, which streams by RDT.

    Its samples: rdt_sequence (the number of the record in the stream), ft_sequence (of the box's
    own measurement, at 7000 Hz), status (see SATURATION_BIT, ERROR_BIT), force [N] and torque [Nm]
    on the sensor's tool side, in the axes that the box is set to.
    """

    columns = (*COUNTER_COLUMNS, *UNITS)

    def __init__(
        self, address: str, bias: bool = False, port: int = PORT, http_port: int = 80
    ) -> None:
        """Connect to the box; bias: whether to zero the sensor first, by the box's software bias;
        port: of RDT; http_port: of the box's web page.

        Raises InputError also where the box does not stream or has unknown units.
        """
        self._box = f"the Net F/T box at {address}"
        settings = _settings(f"http://{address}:{http_port}/netftapi2.xml")
        counts, units = self._counts(settings), self._units(settings)
        self._scale = np.repeat([1.0, units[0] / counts[0], units[1] / counts[1]], 3)
        self._socket = self._connect(address, port, bias)
        self._records = Counter(SEQUENCE_BITS, MAX_RECORD_RATE)
        self._silence = Silence(self._box)
        self.identity = Identity(
            model=settings.get("prodname", "ATI Net F/T"),
            address=address,
            serial_number=settings.get("cfgcalsn", ""),
            firmware=settings.get("mfgdigver", ""),
            units=UNITS,
            counts_per_unit={"force": counts[0], "torque": counts[1]},
            box_units={"force": settings["scfgfu"], "torque": settings["scfgtu"]},
            rate_hz=_number(settings, "comrdtrate") or _number(settings, "commrdtrate"),
            bias=bias,
        )

    def read(self) -> NewSamples:
        """Return the samples that arrive within 0.05 s, as `Device.read`."""
        received, records, lost = [], [], 0
        until = time.monotonic() + GATHERING_TIME
        while datagram := self._receive(until):
            record = decode(datagram)
            before = self._records.lost_before(record[0]) if record else None
            if before is not None:
                received.append(time.monotonic())
                records.append(record)
                lost += before
        self._silence.check(len(received))
        values = np.array(records, float).reshape(-1, len(self.columns)) * self._scale
        return NewSamples(np.array(received), values, lost)

    def close(self) -> None:
        """Stop the stream."""
        with contextlib.suppress(OSError):  # the box may have gone
            self._socket.send(request(STOP))
        self._socket.close()

    def _connect(self, address: str, port: int, bias: bool) -> socket.socket:
        """Return the connection with the stream started and its first record waiting."""
        connection = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        connection.settimeout(ANSWER_TIMEOUT / REQUEST_ATTEMPTS)
        for _ in range(REQUEST_ATTEMPTS):
            try:
                connection.connect((address, port))  # ignores other senders
                if bias:
                    connection.send(request(SET_BIAS))
                connection.send(request(STREAM))
                connection.recv(1, socket.MSG_PEEK)
                return connection
            except OSError:
                continue
        connection.close()
        raise InputError(
            f"{self._box} sends no records from UDP port {port}; enable RDT on its page "
            "“Communications” and open the port in the firewall"
        )

    def _receive(self, until: float) -> bytes | None:
        """Return the next datagram; None if none arrives before `until` [s, monotonic]."""
        remaining = until - time.monotonic()
        if remaining <= 0:
            return None
        self._socket.settimeout(remaining)
        try:
            return self._socket.recv(2 * RECORD.size)
        except TimeoutError:
            return None
        except OSError as error:
            raise DeviceLost(f"{self._box} has gone") from error

    def _counts(self, settings: dict[str, str]) -> tuple[float, float]:
        """Return the counts per unit of force, and per unit of torque."""
        force, torque = _number(settings, "cfgcpf"), _number(settings, "cfgcpt")
        if force is None or torque is None:
            raise InputError(
                f"{self._box} states no counts per force and torque; choose a calibration on its "
                "page “Configurations”"
            )
        return force, torque

    def _units(self, settings: dict[str, str]) -> tuple[float, float]:
        """Return the box's unit of force [N], and of torque [Nm]."""
        names = [settings.get(name, "").lower().replace("-", "") for name in ("scfgfu", "scfgtu")]
        if names[0] not in FORCE_UNITS or names[1] not in TORQUE_UNITS:
            raise InputError(
                f"{self._box} has unknown units “{names[0]}” and “{names[1]}”; set N and Nm on its "
                "page “Configurations”"
            )
        return FORCE_UNITS[names[0]], TORQUE_UNITS[names[1]]


def _settings(url: str) -> dict[str, str]:
    """Return the elements of a box's netftapi2.xml as text."""
    try:
        with requests.Session() as session:
            session.trust_env = False  # the box is in the local network, behind no proxy
            reply = session.get(url, timeout=ANSWER_TIMEOUT, stream=True, allow_redirects=False)
            reply.raise_for_status()
            page = next(reply.iter_content(MAX_PAGE_BYTES), b"")
    except (requests.RequestException, OSError) as error:
        raise InputError(
            f"no Net F/T box answers at {url}; check its power, the network cable and the address "
            "in the study"
        ) from error
    try:
        # ElementTree loads no external entities, and expat limits the expansion of others.
        root = ElementTree.fromstring(page)
    except ElementTree.ParseError as error:
        raise InputError(
            f"{url} is not the page of a Net F/T box; check the address in the study"
        ) from error
    return {element.tag: (element.text or "").strip() for element in root}


def _number(settings: dict[str, str], name: str) -> float | None:
    """Return a setting that is a positive number; None otherwise."""
    try:
        number = float(settings[name])
    except (KeyError, ValueError):
        return None
    return number if 0 < number < math.inf else None

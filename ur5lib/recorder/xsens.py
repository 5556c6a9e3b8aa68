"""Xsens MTi: an inertial measurement unit at a serial port, as a device to record.

Requests and their data: Xsens, MT Low-Level Communication Protocol Documentation.
"""

import struct
import time

import numpy as np

from ur5lib.channels import columns
from ur5lib.errors import InputError
from ur5lib.recorder import xbus
from ur5lib.recorder.device import Counter, DeviceLost, Identity, NewSamples, Silence
from ur5lib.recorder.xbus import Measurement, Message, RefusedError, XbusPort

GO_TO_CONFIG, GO_TO_MEASUREMENT = 0x30, 0x10
REQUEST_DEVICE_ID, REQUEST_PRODUCT_CODE, REQUEST_FIRMWARE = 0x00, 0x1C, 0x12
SET_OUTPUT_CONFIGURATION = 0xC0  # identifier and rate [Hz] of each item of MTData2
SET_PERIOD, SET_SKIP_FACTOR = 0x04, 0xD4  # the older MTi
SET_OUTPUT_MODE, SET_OUTPUT_SETTINGS = 0xD0, 0xD2
WITH_EACH_SAMPLE = 0xFFFF  # rate of counter and time
PERIOD_CLOCK = 115_200  # Hz, in whose ticks the older MTi's sampling period is given
MODE, SETTINGS = xbus.CALIBRATED, xbus.SAMPLE_COUNTER

GATHER = 0.05  # s, for which one call collects samples
UNITS = {"imu_a": "m/s²", "imu_g": "rad/s", "imu_m": "a.u."}
CHANNELS = {channel: unit for name, unit in UNITS.items() for channel in columns(name)}


class Xsens:
    """The motion tracker at a serial port, set to a rate.

    Columns: sample_counter (without the wrap-around of the device's), sample_time_fine (device time
    in ticks of 0.1 ms; NaN from an MTi of the first generation), specific force [m/s²], angular
    rate [rad/s] and magnetic field [arbitrary units, about 1 in the Earth's field], calibrated, in
    the tracker's axes.
    """

    name = "imu"
    columns = ("sample_counter", "sample_time_fine", *CHANNELS)

    def __init__(self, port: str, rate_hz: float = 100.0, baudrate: int = 115_200) -> None:
        """port: `/dev/ttyUSB0` or another terminal; baudrate: as configured on the device.

        A sample takes 62 bytes: on an RS-232 line, 256 Hz need 230,400 baud; USB ignores the rate.
        """
        self._path, self._rate_hz, self._baudrate = port, rate_hz, baudrate
        self._port: XbusPort | None = None

    def open(self) -> Identity:
        """Configure the device, start it, and return the manifest's entry.

        Raises InputError when the port cannot be opened or the device does not answer.
        """
        self.close()
        self._port = port = XbusPort(self._path, self._baudrate)
        try:
            port.ask(GO_TO_CONFIG)
            message, rate = self._configure(port)
            identity = self._identity(port, message, rate)
            port.ask(GO_TO_MEASUREMENT)
        except (InputError, RefusedError) as error:
            self.close()
            if isinstance(error, InputError):
                raise
            raise InputError(
                f"the motion tracker at {self._path} does not accept {self._rate_hz:g} Hz; choose "
                "a rate that it offers"
            ) from error
        self._counter = Counter(xbus.COUNTER_BITS, rate)
        self._silence = Silence(f"the motion tracker at {self._path}")
        return identity

    def read(self) -> NewSamples:
        """Return the samples that have arrived, after waiting 0.05 s for more.

        Samples that arrive together share their time of arrival. Raises DeviceLost when the last
        one is 1 s ago or the port has gone.
        """
        if self._port is None:
            raise DeviceLost(f"the motion tracker at {self._path} is not open")
        received, rows, lost = [], [], 0
        until = time.monotonic() + GATHER
        while time.monotonic() < until:
            messages, now = self._port.receive(), time.monotonic()
            for measurement in filter(None, map(self._decode, messages)):
                before = self._counter.lost_before(measurement.counter)
                if before is not None:
                    received.append(now)
                    stamp = self._counter.total, measurement.time_fine
                    rows.append([*stamp, *measurement.vectors])
                    lost += before
        self._silence.check(len(received))
        values = np.array(rows, float).reshape(-1, len(self.columns))
        return NewSamples(np.array(received), values, lost)

    def close(self) -> None:
        """Stop the device and close the port."""
        if self._port is None:
            return
        self._port.send(GO_TO_CONFIG)
        self._port.close()
        self._port = None

    def _identity(self, port: XbusPort, message: str, rate_hz: float) -> Identity:
        firmware = port.ask(REQUEST_FIRMWARE)[:3]
        return Identity(
            model=port.ask(REQUEST_PRODUCT_CODE).decode("ascii", "replace").strip(" \0"),
            address=self._path,
            serial_number=port.ask(REQUEST_DEVICE_ID).hex().upper(),
            firmware=".".join(map(str, firmware)),
            units=CHANNELS,
            message=message,
            rate_hz=rate_hz,
        )

    def _configure(self, port: XbusPort) -> tuple[str, float]:
        """Configure the outputs, and return message and rate [Hz].

        The first generation of the MTi, which refuses MTData2, is configured for MTData.
        """
        try:
            self._identifier = xbus.MTDATA2
            return "MTData2", self._configure_mtdata2(port)
        except RefusedError:
            self._identifier = xbus.MTDATA
            period = min(round(PERIOD_CLOCK / self._rate_hz), 0xFFFF)
            port.ask(SET_PERIOD, struct.pack(">H", period))
            port.ask(SET_SKIP_FACTOR, struct.pack(">H", 0))
            port.ask(SET_OUTPUT_MODE, struct.pack(">H", MODE))
            port.ask(SET_OUTPUT_SETTINGS, struct.pack(">I", SETTINGS))
            return "MTData", PERIOD_CLOCK / period

    def _configure_mtdata2(self, port: XbusPort) -> float:
        """Configure MTData2; return the rate [Hz] that the device chose, its nearest one."""
        rate = round(self._rate_hz)
        items = [(xbus.PACKET_COUNTER, WITH_EACH_SAMPLE)]
        items += [(xbus.SAMPLE_TIME_FINE, WITH_EACH_SAMPLE)]
        items += [(vector, rate) for vector in xbus.VECTORS]
        data = b"".join(struct.pack(">HH", *item) for item in items)
        accepted = port.ask(SET_OUTPUT_CONFIGURATION, data)
        rates = dict(struct.iter_unpack(">HH", accepted[: len(accepted) // 4 * 4]))
        return float(rates.get(xbus.ACCELERATION, rate))

    def _decode(self, message: Message) -> Measurement | None:
        if message.identifier != self._identifier:
            return None
        if self._identifier == xbus.MTDATA2:
            return xbus.decode_mtdata2(message.data)
        return xbus.decode_mtdata(message.data)

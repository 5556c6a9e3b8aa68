"""Xsens MTi: an inertial measurement unit at a serial port, as a device to record.

Requests and their data: Xsens, MT Low-Level Communication Protocol Documentation.
"""

import struct
import time

import numpy as np

from ur5lab.recorder import xbus
from ur5lab.recorder.device import GATHERING_TIME, Counter, Identity, NewSamples, Silence
from ur5lab.recorder.xbus import ImuSample, Message, RefusedError, XbusPort
from ur5lib.channels import units_of
from ur5lib.errors import InputError

GO_TO_CONFIG, GO_TO_MEASUREMENT = 0x30, 0x10
REQUEST_DEVICE_ID, REQUEST_PRODUCT_CODE, REQUEST_FIRMWARE = 0x00, 0x1C, 0x12
SET_OUTPUT_CONFIGURATION = 0xC0  # identifier and rate [Hz] of each item of MTData2
SET_PERIOD, SET_SKIP_FACTOR = 0x04, 0xD4  # the older MTi
SET_OUTPUT_MODE, SET_OUTPUT_SETTINGS = 0xD0, 0xD2
WITH_EACH_SAMPLE = 0xFFFF  # rate of counter and time, sent with each sample
PERIOD_CLOCK = 115_200  # Hz; the older MTi gives its sampling period in ticks of this clock

UNITS = units_of("imu_a", "imu_g", "imu_m")


class Xsens:
    """The motion tracker at a serial port, set to a rate.

    Columns: sample_counter (without the wrap-around of the device's), sample_time_fine (device time
    in ticks of 0.1 ms; NaN from an MTi of the first generation), specific force [m/s²], angular
    rate [rad/s] and magnetic field [arbitrary units, about 1 in the Earth's field], calibrated, in
    the tracker's axes.
    """

    columns = ("sample_counter", "sample_time_fine", *UNITS)

    def __init__(self, port: str, rate_hz: float = 100.0, baudrate: int = 115_200) -> None:
        """Open the tracker; port: `/dev/ttyUSB0` or another terminal; baudrate: as configured on
        the device.

        A sample takes 62 bytes: on an RS-232 line, 256 Hz need 230,400 baud; USB ignores the rate.
        Raises InputError also where the port cannot be opened.
        """
        self._port = XbusPort(port, baudrate)
        try:
            self._port.ask(GO_TO_CONFIG)
            message, rate = self._configure(rate_hz)
            self.identity = self._identify(port, message, rate)
            self._port.ask(GO_TO_MEASUREMENT)
        except InputError:
            self.close()
            raise
        except RefusedError as error:
            self.close()
            raise InputError(
                f"the motion tracker at {port} does not accept {rate_hz:g} Hz; choose a rate that "
                "it offers"
            ) from error
        self._counter = Counter(xbus.COUNTER_BITS, rate)
        self._silence = Silence(f"the motion tracker at {port}")

    def read(self) -> NewSamples:
        """Return the samples that arrive within 0.05 s, as `Device.read`.

        Those that arrive together share their time of arrival.
        """
        received, rows, lost = [], [], 0
        until = time.monotonic() + GATHERING_TIME
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
        self._port.send(GO_TO_CONFIG)
        self._port.close()

    def _identify(self, path: str, message: str, rate_hz: float) -> Identity:
        ask = self._port.ask
        return Identity(
            model=ask(REQUEST_PRODUCT_CODE).decode("ascii", "replace").strip(" \0"),
            address=path,
            serial_number=ask(REQUEST_DEVICE_ID).hex().upper(),
            firmware=".".join(map(str, ask(REQUEST_FIRMWARE)[:3])),
            units=UNITS,
            message=message,
            rate_hz=rate_hz,
        )

    def _configure(self, wanted_hz: float) -> tuple[str, float]:
        """Configure the outputs, and return the name of the message and its rate [Hz], for MTData2
        the nearest to the wanted one.

        The first generation of the MTi, which refuses MTData2, is configured for MTData.
        """
        try:
            self._identifier, rate = xbus.MTDATA2, round(wanted_hz)
            items = [(xbus.PACKET_COUNTER, WITH_EACH_SAMPLE)]
            items += [(xbus.SAMPLE_TIME_FINE, WITH_EACH_SAMPLE)]
            items += [(vector, rate) for vector in xbus.VECTORS]
            data = b"".join(struct.pack(">HH", *item) for item in items)
            accepted = self._port.ask(SET_OUTPUT_CONFIGURATION, data)
            rates = dict(struct.iter_unpack(">HH", accepted[: len(accepted) // 4 * 4]))
            return "MTData2", float(rates.get(xbus.ACCELERATION, rate))
        except RefusedError:
            self._identifier = xbus.MTDATA
            period = min(round(PERIOD_CLOCK / wanted_hz), 0xFFFF)
            self._port.ask(SET_PERIOD, struct.pack(">H", period))
            self._port.ask(SET_SKIP_FACTOR, struct.pack(">H", 0))
            self._port.ask(SET_OUTPUT_MODE, struct.pack(">H", xbus.CALIBRATED_MODE))
            self._port.ask(SET_OUTPUT_SETTINGS, struct.pack(">I", xbus.SAMPLE_COUNTER))
            return "MTData", PERIOD_CLOCK / period

    def _decode(self, message: Message) -> ImuSample | None:
        if message.identifier != self._identifier:
            return None
        if self._identifier == xbus.MTDATA2:
            return xbus.decode_mtdata2(message.data)
        return xbus.decode_mtdata(message.data)

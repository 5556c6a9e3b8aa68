"""An arm whose controller speaks RTDE, as a device to record."""

from typing import Any

import numpy as np

from ur5lib.recorder.device import DeviceLost, NewSamples
from ur5lib.recorder.rtde_client import PORT, RtdeClient
from ur5lib.recorder.silence import Silence
from ur5lib.robots.rtde_variables import all_columns

OUTPUTS = (
    "timestamp",
    "target_q",
    "target_qd",
    "target_qdd",
    "target_current",
    "target_moment",
    "actual_q",
    "actual_qd",
    "actual_current",
    "actual_current_as_torque",
    "actual_TCP_pose",
    "actual_TCP_speed",
    "actual_TCP_force",
    "ft_raw_wrench",
    "actual_tool_accelerometer",
    "joint_temperatures",
    "payload",
    "payload_cog",
    "payload_inertia",
    "speed_scaling",
    "robot_mode",
    "safety_mode",
    "runtime_state",
)
RATES = {3: 125.0}  # Hz, of the controller's software; later ones have 500
USUAL_RATE = 500.0
WAIT = 0.1  # s, for which one call waits for samples


class RtdeArm:
    """The arm at an address, recorded package by package through RTDE.

    rate: [Hz], None for the controller's default. columns: those of OUTPUTS that the controller
    has, known once it is open; lost packages are counted by `timestamp`, the controller's clock.
    """

    name = "robot"

    def __init__(self, address: str, rate: float | None = None, port: int = PORT) -> None:
        self._address, self._rate, self._port = address, rate, port
        self._client: RtdeClient | None = None
        self.columns: tuple[str, ...] = ()

    def open(self) -> dict[str, Any]:
        """Connect, start, and return the manifest's entry.

        Raises InputError when no controller answers.
        """
        self._client = RtdeClient(self._address, self._port)
        software = self._client.software
        rate = self._rate or RATES.get(software[0], USUAL_RATE)
        names = self._client.start(OUTPUTS, rate)
        self.columns = all_columns(tuple(names))
        self._cycle, self._last = 1 / rate, np.nan
        self._silence = Silence(self._address)
        return {
            "model": "Universal Robots controller, RTDE",
            "address": self._address,
            "firmware": ".".join(map(str, software)),
            "rate_hz": rate,
            "units": "SI",
            "clock": "timestamp",
            "missing": [name for name in OUTPUTS if name not in names],
        }

    def read(self) -> NewSamples:
        """Return the samples since the last call, after waiting at most 0.1 s.

        Raises DeviceLost when the controller is silent for a second or closes the connection.
        """
        if self._client is None:
            raise DeviceLost(f"{self._address} is not open")
        packages = self._client.receive(WAIT)
        self._silence.check(len(packages))
        received = np.array([arrived for arrived, _ in packages], np.float64)
        values = np.array([numbers for _, numbers in packages], np.float64)
        values = values.reshape(len(packages), len(self.columns))
        return NewSamples(received, values, self._count_lost(values[:, 0]))

    def close(self) -> None:
        """Stop the packages; does nothing when closed or gone."""
        if self._client is not None:
            self._client.close()
            self._client = None

    def _count_lost(self, stamps: np.ndarray) -> int:
        """Return the count of cycles missing before or among timestamps (n,) [s]."""
        if not len(stamps):
            return 0
        steps = np.diff(stamps, prepend=stamps[0] if np.isnan(self._last) else self._last)
        self._last = float(stamps[-1])
        return int(np.maximum(np.rint(steps / self._cycle) - 1, 0).sum())

"""The truth about a recording of the emulated lab, collected from its beginning to its end."""

import threading
from pathlib import Path
from typing import Self

import numpy as np

from ur5lib.stand.engine import TrueMotion
from ur5lib.stand.lab.controller import EmulatedController
from ur5lib.stand.lab.truth import COLUMNS
from ur5lib.stand.rig import STEP, build_rig
from ur5lib.stand.truth import Clocks, write_truth
from ur5lib.timeseries.arrays import Array

INTERVAL = 1.0  # s between copies of the truth, of which the arm keeps the last seconds


class TruthRecorder:
    """The true motion and forces of an emulated arm while the context lasts, every millisecond."""

    def __init__(self, arm: EmulatedController) -> None:
        """arm: a running one."""
        self._arm, self._rows, self._count = arm, list[Array](), 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Self:
        """Begin."""
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """End."""
        self._over.set()
        self._thread.join()

    def write(self, start: float, clocks: Clocks, truth: Path) -> None:
        """Write the truth from the controller's timestamp `start` [s] on, until now.

        clocks: of each sensor, counted from its first sample; truth: path of truth.parquet and
        truth.json without their suffixes.
        """
        self.__exit__()  # completes the rows
        setup = self._arm.setup
        motion = self._motion(round((start - setup.uptime) / STEP))
        rig = build_rig(setup.robot, setup.plan, np.random.default_rng(setup.seed))
        write_truth(rig, setup.plan, motion, 1 / setup.rate, {"clocks": clocks}, truth)

    def _run(self) -> None:
        while not self._over.wait(INTERVAL):
            self._take()
        self._take()

    def _take(self) -> None:
        rows = self._arm.truth.since(self._count)
        self._rows.append(rows)
        self._count += len(rows)

    def _motion(self, first: int) -> TrueMotion:
        rows = np.concatenate(self._rows)[first:]
        parts = {name: rows[:, columns] for name, columns in COLUMNS.items()}
        time: Array = STEP * np.arange(len(rows), dtype=np.float64)
        return TrueMotion(time=time, **parts)

"""Low-pass the measured signals without delay."""

from functools import partial
from typing import Any

import pandas as pd

from ur5lib.steps import run_step
from ur5lib.tables import period, read_table, write_table
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment

MEASURED = ("actual_q_", "actual_qd_", "actual_current_", "ft_", "imu_")


def filter_signals(input: Any, output: Any, params: Any) -> None:
    signals = read_table(input.signals)
    lowpass = partial(
        zero_phase_lowpass, rate=1 / period(signals), order=params.order, cutoff=params.cutoff_hz
    )
    segment = signals["segment"].to_numpy()
    filtered = signals[["time", "segment"]]
    for prefix in MEASURED:
        channels = signals.filter(regex=f"^{prefix}")
        if not channels.empty:
            values = by_segment(lowpass, channels.to_numpy(float), segment)
            filtered = filtered.join(pd.DataFrame(values, columns=channels.columns))
    write_table(filtered, output.filtered)


if __name__ == "__main__":
    run_step(filter_signals, snakemake)  # type: ignore[name-defined]  # noqa: F821

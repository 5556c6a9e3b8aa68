"""Joint motion: filtered positions and velocities, and accelerations from them."""

from functools import partial
from typing import Any

import pandas as pd

from ur5lib.signals.lowpass import by_segment
from ur5lib.signals.motion import differentiate
from ur5lib.steps import run_step
from ur5lib.tables import channel, named, period, read_table, write_table


def smooth_motion(input: Any, output: Any, params: Any) -> None:
    filtered = read_table(input.filtered)
    differentiated = partial(
        by_segment,
        partial(differentiate, period=period(filtered)),
        segment=filtered["segment"].to_numpy(),
    )
    q = channel(filtered, "actual_q")
    measured = "actual_qd_0" in filtered
    qd = channel(filtered, "actual_qd") if measured else differentiated(values=q)
    qdd = differentiated(values=qd)
    columns = named(q, "q") | named(qd, "qd") | named(qdd, "qdd")
    motion = filtered[["time", "segment"]].join(pd.DataFrame(columns))
    write_table(motion, output.motion)


if __name__ == "__main__":
    run_step(smooth_motion, snakemake)  # type: ignore[name-defined]  # noqa: F821

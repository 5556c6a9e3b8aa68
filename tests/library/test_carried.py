"""What an arm carries: who says so, and what the controller reckons with."""

import numpy as np
import pandas as pd
import pytest

from ur5lib.pipeline.carried import carried
from ur5lib.robots.description import Payload
from ur5lib.tables import named

DECLARED = Payload(mass=0.46, center_of_mass=(0.0, 0.0, 0.02))
TOLD = Payload(mass=1.5, center_of_mass=(0.01, 0.02, 0.03), inertia=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0))


def recorded(payload: Payload | None, count: int = 5) -> pd.DataFrame:
    """Signals with RTDE's channels of a payload, if any; their first and last row are wrong."""
    time = {"time": np.arange(count) * 0.002}
    if payload is None:
        return pd.DataFrame(time)
    rows = [payload.mass, *payload.center_of_mass, *payload.inertia]
    values = np.tile(rows, (count, 1))
    values[0], values[-1] = np.nan, 100.0
    mass = {"payload": values[:, 0]}
    cog, inertia = named(values[:, 1:4], "payload_cog"), named(values[:, 4:], "payload_inertia")
    return pd.DataFrame(time | mass | cog | inertia)


@pytest.mark.parametrize(
    ("declared", "channels", "payload", "source", "told"),
    [
        (None, None, None, "none", None),
        (DECLARED, None, DECLARED, "study", None),
        (None, TOLD, TOLD, "rtde", TOLD),
        (DECLARED, TOLD, DECLARED, "study", TOLD),
    ],
)
def test_the_study_comes_first_and_only_channels_tell_the_controller(
    declared: Payload | None,
    channels: Payload | None,
    payload: Payload | None,
    source: str,
    told: Payload | None,
) -> None:
    found = carried(declared, recorded(channels))
    assert (found.payload, found.source, found.told) == (payload, source, told)


def test_a_mass_may_come_without_the_rest() -> None:
    signals = recorded(TOLD).filter(regex="^(time|payload)$")
    assert carried(None, signals).payload == Payload(mass=1.5)


@pytest.mark.parametrize("mass", [0.0, np.nan, -1.0])
def test_an_empty_flange_is_no_payload(mass: float) -> None:
    signals = recorded(TOLD).assign(payload=mass)
    assert carried(None, signals).source == "none"

"""What an arm carries: who says so, and what the controller reckons with."""

from dataclasses import replace

import numpy as np
import pytest

from ur5lib.pipeline.carried import carried
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import Payload

DECLARED = Payload(mass=0.46, center_of_mass=(0.0, 0.0, 0.02))
TOLD = Payload(mass=1.5, center_of_mass=(0.01, 0.02, 0.03), inertia=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0))


def recorded(payload: Payload | None, count: int = 5) -> Signals:
    """Signals with RTDE's channels of a payload, if any; their first and last row are wrong."""
    signals = Signals(
        time=np.arange(count) * 0.002,
        segment=np.zeros(count, np.int64),
        interpolated=np.zeros(count, bool),
        actual_q=np.zeros((count, 6)),
    )
    if payload is None:
        return signals
    rows = [payload.mass, *payload.center_of_mass, *payload.inertia]
    values = np.tile(rows, (count, 1))
    values[0], values[-1] = np.nan, 100.0
    mass, cog, inertia = np.split(values, [1, 4], axis=1)
    return replace(signals, payload=mass[:, 0], payload_cog=cog, payload_inertia=inertia)


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
    signals = replace(recorded(TOLD), payload_cog=None, payload_inertia=None)
    assert carried(None, signals).payload == Payload(mass=1.5)


@pytest.mark.parametrize("mass", [0.0, np.nan, -1.0])
def test_an_empty_flange_is_no_payload(mass: float) -> None:
    signals = replace(recorded(TOLD), payload=np.full(5, mass))
    assert carried(None, signals).source == "none"

"""What an arm carries: who says so, and what the controller reckons with."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import said
from tests.made_records import signals_of
from ur5lib.records.carried import carried, disagreements
from ur5lib.records.codes import Found
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload

DECLARED = Payload(mass=0.46, center_of_mass=(0.0, 0.0, 0.02))
TOLD = Payload(mass=1.5, center_of_mass=(0.01, 0.02, 0.03), inertia=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
NOTHING = Payload.model_construct(mass=0.0, center_of_mass=(0.0, 0.0, 0.0), inertia=(0.0,) * 6)


def recorded(payload: Payload | None, count: int = 5, steady: bool = False) -> Signals:
    """Signals with RTDE's channels of a payload, if any: steady, or wrong in first and last row."""
    signals = signals_of(np.arange(count) * 0.002, np.zeros((count, 6)))
    if payload is None:
        return signals
    rows = [payload.mass, *payload.center_of_mass, *payload.inertia]
    values = np.tile(rows, (count, 1))
    if not steady:
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
    assert (found.payload, found.source, found.configured) == (payload, source, told)


def test_a_mass_may_come_without_the_rest() -> None:
    signals = replace(recorded(TOLD), payload_cog=None, payload_inertia=None)
    assert carried(None, signals).payload == Payload(mass=1.5)


@pytest.mark.parametrize("mass", [0.0, np.nan, -1.0])
def test_an_empty_flange_is_no_payload(mass: float) -> None:
    signals = replace(recorded(TOLD), payload=np.full(5, mass))
    assert carried(None, signals).source == "none"


# Where file and study disagree


@pytest.mark.parametrize(
    ("declared", "channels", "words"),
    [
        (None, TOLD, None),
        (TOLD, None, None),
        (TOLD, TOLD, None),
        (TOLD.model_copy(update={"mass": 1.53}), TOLD, None),
        (
            DECLARED,
            TOLD,
            ["0.46 kg at (0, 0, 0.02) m", "1.5 kg at (0.01, 0.02, 0.03) m"],
        ),
        (TOLD.model_copy(update={"center_of_mass": (0.0, 0.0, 0.2)}), TOLD, ["at (0, 0, 0.2) m"]),
        (DECLARED, NOTHING, ["no payload"]),
    ],
)
def test_another_payload_than_the_controller_s_is_told(
    declared: Payload | None, channels: Payload | None, words: list[str] | None
) -> None:
    found = disagreements(declared, None, recorded(channels, steady=True))
    assert [one.code for one in found] == (["payload"] if words else [])
    assert all(text in said(one) for one in found for text in words or [])


def test_a_payload_that_changes_is_told() -> None:
    (found,) = disagreements(None, None, recorded(TOLD))
    assert "changes from 1.5 to 100 kg" in said(found)


@pytest.mark.parametrize(("tcp", "told"), [(0.1, False), (0.103, False), (0.12, True)])
def test_another_tool_centre_point_than_the_controller_s_is_told(tcp: float, told: bool) -> None:
    signals = replace(recorded(None), tcp_offset=np.tile([0, 0, 0.1, 0, 0, 0], (5, 1)))
    found = disagreements(None, (0.0, 0.0, tcp, 0.0, 0.0, 0.0), signals)
    assert [one.code for one in found] == ([Found.TOOL_CENTRE_POINT] if told else [])

"""Clocks, resampling, low-pass and differentiation."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ur5lib.signals.clock import clock_from_stamps
from ur5lib.signals.resampling import resample
from ur5lib.timeseries.lowpass import causal_lowpass, zero_phase_lowpass
from ur5lib.timeseries.sampling import differentiate
from ur5lib.timeseries.segments import by_segment

RATE = 125.0
TIME = np.arange(2000) / RATE


def wave(frequency: float, phase: float = 0.0) -> np.ndarray:
    return np.sin(2 * np.pi * frequency * TIME + phase)[:, None]


def gain_and_delay(filtered: np.ndarray, frequency: float) -> tuple[float, float]:
    """Of a wave, away from the ends: gain, and delay in seconds."""
    middle = slice(800, 1200)
    turning = np.exp(-2j * np.pi * frequency * TIME)[:, None]
    ratio = (filtered * turning)[middle].sum() / (wave(frequency) * turning)[middle].sum()
    return abs(ratio), -np.angle(ratio) / (2 * np.pi * frequency)


@pytest.mark.parametrize("order", [1, 2, 5, 8])
def test_gain_at_the_cutoff(order: int) -> None:
    """-3 dB for one pass (Equation 5.12), -6 dB for two."""
    cutoff = 5.0
    once, _ = gain_and_delay(causal_lowpass(wave(cutoff), RATE, order, cutoff), cutoff)
    twice, delay = gain_and_delay(zero_phase_lowpass(wave(cutoff), RATE, order, cutoff), cutoff)
    assert once == pytest.approx(np.sqrt(0.5), rel=0.01)
    assert twice == pytest.approx(0.5, rel=0.01)
    assert delay == pytest.approx(0, abs=1e-4)


def test_the_thesis_filter_delays_by_a_third_of_a_second() -> None:
    """Erratum 5: order 5 at 1.454 Hz."""
    _, delay = gain_and_delay(causal_lowpass(wave(0.3125), RATE, 5, 1.454), 0.3125)
    assert delay == pytest.approx(0.35, abs=0.01)


def test_constants_pass_to_the_ends() -> None:
    level = np.full((300, 2), 7.0)
    np.testing.assert_allclose(zero_phase_lowpass(level, RATE, 4, 10), level)


@pytest.mark.parametrize("cutoff", [0.0, -1.0, np.nan])
def test_a_cutoff_that_is_none_is_refused(cutoff: float) -> None:
    with pytest.raises(ValueError, match="is not above zero"):
        zero_phase_lowpass(wave(1), RATE, 4, cutoff)


@pytest.mark.parametrize("cutoff", [62.5, 100.0, 1000.0])
def test_a_cutoff_beyond_nyquist_changes_nothing(cutoff: float) -> None:
    """Each recording has its own: at 500 Hz, the same cut-offs do filter."""
    for lowpass in (zero_phase_lowpass, causal_lowpass):
        np.testing.assert_array_equal(lowpass(wave(20), RATE, 4, cutoff), wave(20))
    whole = zero_phase_lowpass(wave(20), 500.0, 4, cutoff)
    assert (np.abs(whole - wave(20)).max() > 1e-3) == (cutoff < 250)


def test_segments_do_not_touch_one_another() -> None:
    values = np.concatenate([np.zeros((200, 1)), np.ones((200, 1))])
    segment = np.repeat([0, 1], 200)
    smooth = by_segment(lambda x: zero_phase_lowpass(x, RATE, 4, 5), values, segment)
    np.testing.assert_allclose(smooth, values, atol=1e-12)


def test_missing_rows_stay_missing_and_break_a_segment() -> None:
    values = np.concatenate([np.zeros((200, 1)), [[np.nan]], np.ones((200, 1))])
    smooth = by_segment(
        lambda x: zero_phase_lowpass(x, RATE, 4, 5), values, np.zeros(401, dtype=int)
    )
    np.testing.assert_allclose(smooth, values, atol=1e-12)


@pytest.mark.parametrize("length", [1, 2, 5])
def test_short_segments_do_not_fail(length: int) -> None:
    values = np.ones((length, 3))
    np.testing.assert_allclose(zero_phase_lowpass(values, RATE, 4, 5), values)


def test_derivative_of_a_parabola_is_exact_inside() -> None:
    slope = differentiate(TIME[:, None] ** 2, 1 / RATE)
    np.testing.assert_allclose(slope[1:-1, 0], 2 * TIME[1:-1], atol=1e-9)
    assert np.isnan(differentiate(np.ones((1, 2)), 1 / RATE)).all()


@given(offset=st.floats(-1, 1))
def test_a_shifted_clock_is_put_right(offset: float) -> None:
    """t_robot = offset + t_device: a line seen by the device is a line on the robot's clock."""
    own = np.arange(0, 4, 0.005)
    device = pd.DataFrame({"time": own, "ft_fx": 3 * (own + offset)})
    aligned = resample(device, clock_from_stamps(offset, 0.01), TIME)["ft_fx"].to_numpy()
    seen = (offset <= TIME) & (own[-1] + offset >= TIME)
    np.testing.assert_allclose(aligned[seen], 3 * TIME[seen], atol=1e-9)
    assert np.isnan(aligned[(offset - 1e-9 > TIME) | (own[-1] + offset + 1e-9 < TIME)]).all()

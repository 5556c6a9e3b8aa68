"""Bands of the joints' motion: what colour widens, and how many hold the truth on the stand."""

import numpy as np

from benchmarks.motion import judged, simulated, with_imu
from ur5lib.smoothing.encoders import widening
from ur5lib.timeseries.kalman import innovation_test


def test_colour_widens_by_what_averages_out_less() -> None:
    """Of an autoregressive series, 1 + 2 Σ ρ is (1 + a)/(1 − a); white and restless ones do not."""
    random = np.random.default_rng(0)
    white = random.normal(size=(40_000, 12))
    share = np.zeros(12)
    share[3], share[10], share[5] = 0.5, 0.3, -0.5
    series = white.copy()
    for k in range(1, len(series)):
        series[k] = share * series[k - 1] + white[k]
    test = innovation_test(series, np.zeros(len(series), np.int64))
    expected = np.sqrt([1, 1, 1, 3, 1.3 / 0.7, 1])
    np.testing.assert_allclose(widening(test, joints=6), expected, rtol=0.05)


def test_bands_hold_the_true_motion_and_an_imu_halves_the_shaking() -> None:
    own = simulated("moves", 0, 12.0)
    moving, _, ratios = judged(own)
    assert (moving > 0.92).all()
    assert (moving < 0.985).all()
    assert np.mean(ratios) < 0.85
    shaken, bridged, alone = with_imu(own)
    assert shaken < 0.6
    assert bridged < 1e-3 < alone

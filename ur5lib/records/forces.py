"""Estimates of the contact wrench, and the force sensor's wrenches."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ur5lib.records.motion import Motion
from ur5lib.records.table import JOINTS, WRENCH, SegmentedTable, channel
from ur5lib.timeseries.arrays import Array, Mask

AXES = ("x", "y", "z")
REFERENCES = ("printed", "corrected", "compensated")


class Estimate(Protocol):
    """An estimator's contact wrench and band, see `ur5lib.force.estimators.Stated`."""

    @property
    def wrench(self) -> Array:
        """The contact wrench (N, 6) [N, Nm]."""

    @property
    def std(self) -> Array | None:
        """The wrench's standard deviation (N, 6) [N, Nm], None if it is not stated."""

    @property
    def log_odds(self) -> Array | None:
        """Log-odds (N,) of contact, None if the estimator is not gated."""


class Leading(Protocol):
    """What the leading estimate also states, see `ur5lib.force.wrench_estimate`."""

    background: Array
    untouched: Array
    hidden: Array
    hidden_at_all: Array
    unsmoothed: Array
    link: Array
    off_flange: Array


@dataclass(frozen=True, kw_only=True)
class Forces(SegmentedTable):
    """Contact wrenches from currents: the environment acting on the arm, base axes, frame 6's
    origin, (N, 6) [N, Nm].

    wrench, and std, its standard deviation, if stated: by estimate; log_odds: of a contact given
    all samples, (N,); background: (N, 6) [Nm], slow external torque that is no contact;
    if_untouched: (N,), where no contact is found: there, the leading estimate's band is valid only
    if nothing touches the arm.

    Of the leading estimate, (N, 3) [N]: untouched, half of the 95 % band of the force if nothing
    has touched since the arm came to rest, of the band itself in motion and in contacts; hidden, up
    to which a contact since then could be hidden, and hidden_at_all, also one that lasts longer,
    zero in contacts; unsmoothed, the force before it is averaged at rest, for peaks. And (N,), of a
    contact in motion, NaN elsewhere: link, the likeliest, from 1; off_flange, the probability that
    it is not the last one.
    """

    wrench: dict[str, Array] = channel("{}", "N, Nm", WRENCH)
    std: dict[str, Array] = channel("{}_std", "N, Nm", WRENCH)
    log_odds: dict[str, Array] = channel("log_odds_{}", "1", ())
    background: Array | None = channel("tau_background", "Nm", JOINTS, optional=True)
    if_untouched: Mask | None = channel("if_untouched", "1", optional=True, dtype=np.bool_)

    untouched: Array | None = channel("untouched", "N", AXES, optional=True)
    hidden: Array | None = channel("hidden", "N", AXES, optional=True)
    hidden_at_all: Array | None = channel("hidden_at_all", "N", AXES, optional=True)
    unsmoothed: Array | None = channel("unsmoothed", "N", AXES, optional=True)
    link: Array | None = channel("link", "1", (), optional=True)
    off_flange: Array | None = channel("off_flange", "1", (), optional=True)

    @classmethod
    def of(
        cls, motion: Motion, estimates: Mapping[str, Estimate | None], fmap: Leading | None
    ) -> "Forces":
        """Return estimates by name, at the times of a motion; fmap: the leading one, None without
        it.
        """
        known = {name: one for name, one in estimates.items() if one is not None}
        odds = {name: one.log_odds for name, one in known.items()}
        leading = next((one for one in known.values() if one.log_odds is not None), None)
        names = () if fmap is None else Leading.__annotations__
        return cls(
            time=motion.time,
            segment=motion.segment,
            wrench={name: one.wrench for name, one in known.items()},
            std={name: one.std for name, one in known.items() if one.std is not None},
            log_odds={name: own for name, own in odds.items() if own is not None},
            if_untouched=None if leading is None else np.all(leading.wrench == 0, axis=1),
            **{name: getattr(fmap, name) for name in names},
        )


@dataclass(frozen=True, kw_only=True)
class FurtherForces(SegmentedTable):
    """Estimates from other sources, such as the controller or a topic, (N, 6) [N, Nm]: as printed,
    and corrected; the environment acting on the arm, base axes.
    """

    printed: dict[str, Array] = channel("printed_{}", "N, Nm", WRENCH)
    corrected: dict[str, Array] = channel("corrected_{}", "N, Nm", WRENCH)


@dataclass(frozen=True, kw_only=True)
class SensorWrenches(SegmentedTable):
    """The force sensor's wrench, (N, 6) [N, Nm], the environment acting on the arm, base axes.

    printed: the raw reading; corrected: less its mean at the start, both timed by start stamps;
    compensated: timed by the best clock, less bias and tool weight; the last two at frame 6's
    origin. plain: the wrench by plain least squares, for comparison with the estimates.
    """

    wrench: dict[str, Array] = channel("{}", "N, Nm", WRENCH, keys=REFERENCES)
    plain: Array | None = channel("plain_least_squares", "N, Nm", WRENCH, optional=True)

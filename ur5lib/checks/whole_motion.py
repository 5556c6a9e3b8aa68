"""How well measured efforts are explained by the whole motion: of the declared links, and of any.

The declared explanation is the torque of the described links (gravity, inertia and what their
speeds need) with friction and an offset of each joint. The free one is that of any links on the
described axes, one set of inertial parameters for all joints, with the same friction: its rival.
Both are judged on stretches of time that their fits leave out, by the logarithm of the mean square
of what they miss: of 0.1, a mean square differs by a tenth.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ur5lib.channels import TORQUE
from ur5lib.checks.block_means import FULL_FRICTION_SPEED, BlockMeans
from ur5lib.checks.currents import MAX_CONSTANT_RATIO
from ur5lib.robots.description import Robot
from ur5lib.robots.drives import shaft_matrix
from ur5lib.robots.inertia import inertial_parameters, rigid_bodies
from ur5lib.robots.newton_euler import torque_regressor
from ur5lib.timeseries.arrays import Array

STRETCHES = 10  # time is cut into this many stretches, each of which is left out once
MAX_BLOCKS = 600  # this many blocks of a log are looked at
# Columns have unit size. The ridge that misses least is taken, so that few blocks are not
# overfitted.
RIDGES = (1e-4, 3e-3, 3e-2)
WEIGHING_ROUNDS = 3  # each round estimates each joint's noise
TORQUE_NOISE = 0.02  # Nm; nothing is explained better


class Misfit(NamedTuple):
    """What an explanation of torques misses: logarithms of mean squares by joint (n,), and by
    stretch of time and joint (STRETCHES, n).
    """

    whole: Array
    stretches: Array


class Lead(NamedTuple):
    """By how much an explanation misses less than another. size: difference of the logarithms of
    mean squares, as the mean over some joints; errors: its mean over stretches of time in standard
    errors.
    """

    size: float
    errors: float


def lead(other: Misfit, first: Misfit, joints: Sequence[int]) -> Lead:
    """Return by how much `other` misses less than `first`, as the mean over joints; positive:
    `other` is better. joints: indices from 0.
    """
    chosen = [*joints]
    gains = (first.stretches - other.stretches)[:, chosen].mean(axis=1)
    error = gains.std(ddof=1) / np.sqrt(len(gains)) + 1e-9
    return Lead(float((first.whole - other.whole)[chosen].mean()), float(gains.mean() / error))


class Regression:
    """Least-squares fits of columns (M, n, C) to torques (M, n) of all joints at once, each without
    one of STRETCHES parts of the time.
    """

    def __init__(self, columns: Array, ridges: Sequence[float] = RIDGES[:1]) -> None:
        """Sum the products of columns by stretch and joint; ridges: of which the one that misses
        least is taken.
        """
        size = np.sqrt((columns**2).mean(axis=(0, 1)))
        self.ridges, self.size = ridges, np.where(size > 1e-9, size, np.inf)
        self.columns = columns / self.size
        self.parts = np.array_split(np.arange(len(columns)), STRETCHES)
        by_joint = self.columns.swapaxes(0, 1)
        products = [by_joint[:, own].mT @ by_joint[:, own] for own in self.parts]
        self.products = np.stack(products)  # (STRETCHES, n, C, C)
        self.whole = self.products.sum(axis=0)

    def misfit(self, torque: Array) -> Misfit:
        """Return what the fits miss of a torque (M, n) [Nm] in the stretches left out of them."""
        left = self._left(torque, self._best(torque))
        squares = [(left[own] ** 2).mean(axis=0) for own in self.parts]
        whole = (left**2).mean(axis=0)
        return Misfit(*(np.log(np.array(own) + TORQUE_NOISE**2) for own in (whole, squares)))

    def coefficients(self, torque: Array) -> Array:
        """Return the coefficients (STRETCHES, C) of the fits, each without one stretch."""
        return self._best(torque) / self.size

    def _best(self, torque: Array) -> Array:
        """Return the coefficients (STRETCHES, C) of unit columns by the ridge that misses least,
        all joints counting alike.
        """

        def missed(fit: Array) -> float:
            square = (self._left(torque, fit) ** 2).mean(axis=0)
            return float(np.log(square + TORQUE_NOISE**2).sum())

        sides = [np.einsum("mjc,mj->jc", self.columns[own], torque[own]) for own in self.parts]
        fits = [self._coefficients(torque, np.stack(sides), ridge) for ridge in self.ridges]
        return min(fits, key=missed) if len(fits) > 1 else fits[0]

    def _left(self, torque: Array, coefficients: Array) -> Array:
        parts = zip(self.parts, coefficients, strict=True)
        return np.concatenate([torque[own] - self.columns[own] @ fit for own, fit in parts])

    def _coefficients(self, torque: Array, sides: Array, ridge: float) -> Array:
        """Return the coefficients (STRETCHES, C) of unit columns by one ridge, joints weighted by
        their noise.

        sides: products of columns and torque (STRETCHES, n, C).
        """
        penalty, side = ridge * len(torque) * np.eye(self.columns.shape[2]), sides.sum(axis=0)

        def solved(summed: Array, right: Array) -> Array:
            return np.linalg.solve(summed + weight.mean() * penalty, right[..., None])[..., 0]

        square = torque.var(axis=0)
        for _ in range(WEIGHING_ROUNDS):
            weight = 1 / (square + TORQUE_NOISE**2)
            fit = solved(np.einsum("j,jcd->cd", weight, self.whole), weight @ side)
            square = ((torque - self.columns @ fit) ** 2).mean(axis=0)
        weight = 1 / (square + TORQUE_NOISE**2)
        own = np.einsum("j,sjcd->scd", weight, self.products)  # of each stretch, which is left out
        return solved(own.sum(axis=0) - own, weight @ side - weight @ sides)


class WholeMotion:
    """A motion of an arm with what it carries, and the efforts that should drive it."""

    def __init__(self, means: BlockMeans, arm: Robot) -> None:
        """Take the means of at most MAX_BLOCKS blocks."""
        if len(means.q) > MAX_BLOCKS:
            means = means.part(np.linspace(0, len(means.q) - 1, MAX_BLOCKS).astype(np.intp))
        self.means, self.arm, self.joints = means, arm, range(means.q.shape[1])

    @cached_property
    def torque(self) -> Array:
        """Return the efforts (M, n) [Nm], currents by the maker's torque constants."""
        return self.means.effort * self.arm.maker_torque_constants()

    @cached_property
    def regressor(self) -> Array:
        """Return Y (M, n, 11 n) of the links' torque Y π."""
        return torque_regressor(self.arm, self.means.q, self.means.qd, self.means.qdd)

    @cached_property
    def links(self) -> Array:
        """Return the torque (M, n) [Nm] of the described links, rotors included where described."""
        bodies = rigid_bodies(self.arm, self.arm.fullest_model())
        return np.asarray(self.regressor @ inertial_parameters(self.arm, bodies))

    @cached_property
    def friction(self) -> Array:
        """Return columns (M, n, 3 n): dry friction, viscous friction and offset, by motor."""
        shafts = shaft_matrix(self.arm)
        rate = self.means.qd @ shafts.T
        terms = np.tanh(rate / FULL_FRICTION_SPEED), rate
        own = [term[:, None, :] * shafts.T for term in terms]
        offsets = np.broadcast_to(np.eye(len(self.joints)), own[0].shape)
        return np.concatenate([*own, offsets], axis=2)

    @cached_property
    def rubbing(self) -> Regression:
        """Return the regression on friction and offsets alone."""
        return Regression(self.friction)

    @cached_property
    def any_links(self) -> Regression:
        """Return the regression on the inertial parameters of all links and on friction."""
        return Regression(np.concatenate([self.regressor, self.friction], axis=2), RIDGES)

    def explained(self, torque: Array | None = None) -> "Explained":
        """Return how well the declared links, and any links, explain torques (M, n) [Nm], by
        default the measured efforts.
        """
        return Explained(self, self.torque if torque is None else torque)

    def scale(self, torque: Array) -> Array:
        """Return the factors (n,) by which a torque (M, n) is larger than that of the described
        links.

        They are 1 for measured torques; of currents, they are limited to what the motors' constants
        allow.
        """
        if self.arm.measured == TORQUE:
            return np.ones(len(self.joints))
        return np.clip(self.slopes(torque), 1 / MAX_CONSTANT_RATIO, MAX_CONSTANT_RATIO)

    def slopes(self, torque: Array) -> Array:
        """Return the coefficients (n,) of a torque (M, n) on that of the described links, fitted
        together with friction and an offset.
        """
        slopes = np.ones(len(self.joints))
        for joint in self.joints:
            columns = np.column_stack([self.links[:, joint], self.friction[:, joint]])
            slopes[joint] = np.linalg.lstsq(columns, torque[:, joint], rcond=None)[0][0]
        return slopes

    def friction_in_errors(self) -> Array:
        """Return each joint's friction (n,) at its usual speed, in standard errors (jackknife over
        stretches): the larger of the values fitted with the declared links, where described, and
        with any links.
        """
        count, fits = len(self.joints), [(self.any_links, self.regressor.shape[2])]
        if self.arm.tells_gravity():
            own = self.links[:, :, None] * np.eye(count)
            fits += [(Regression(np.concatenate([own, self.friction], axis=2)), count)]
        speed = np.sqrt((self.means.qd**2).mean(axis=0))
        errors = []
        for regression, first in fits:
            friction = regression.coefficients(self.torque)[:, first : first + 2 * count]
            value = friction[:, :count] + speed * friction[:, count:]
            spread = np.sqrt(STRETCHES - 1) * value.std(axis=0)
            errors.append(value.mean(axis=0) / (spread + 1e-9))
        return np.max(errors, axis=0)

    def with_any_load(self) -> Misfit:
        """Return the misfit of the declared links with any body on the flange."""
        last, scale = 10 * (len(self.joints) - 1), self.scale(self.torque)
        body = scale[:, None] * self.regressor[:, :, last : last + 10]
        loaded = Regression(np.concatenate([body, self.friction], axis=2))
        return loaded.misfit(self.torque - scale * self.links)

    def load(self) -> tuple[float, float, Lead]:
        """Return the mass [kg] on the flange that efforts show in addition to the declared links,
        by the maker's constants, its standard error (jackknife), and the lead over no load.
        """
        last, left = 10 * (len(self.joints) - 1), self.torque - self.links
        body = self.regressor[:, :, last : last + 4]  # mass and first moments
        loaded = Regression(np.concatenate([body, self.friction], axis=2))
        masses = loaded.coefficients(left)[:, 0]
        error = np.sqrt(STRETCHES - 1) * masses.std()
        ahead = lead(loaded.misfit(left), self.rubbing.misfit(left), self.joints)
        return float(masses.mean()), float(error), ahead

    def in_units_of(self, arm: Robot, misfit: Misfit) -> Misfit:
        """Return a misfit as it would be if another arm's torque constants made torques of the
        currents.
        """
        ratio = np.divide(arm.maker_torque_constants(), self.arm.maker_torque_constants())
        return Misfit(*(part + 2 * np.log(ratio) for part in misfit))


class Explained:
    """Torques (M, n) [Nm] of a motion, and what the declared links and any links miss of them."""

    def __init__(self, motion: WholeMotion, torque: Array) -> None:
        """Take a motion and the torques (M, n) [Nm] to be explained."""
        self.motion, self.torque = motion, torque

    @cached_property
    def by_links(self) -> Misfit | None:
        """Return the misfit of the declared links; None if they are unknown."""
        if not self.motion.arm.tells_gravity():
            return None
        links = self.motion.scale(self.torque) * self.motion.links
        return self.motion.rubbing.misfit(self.torque - links)

    @cached_property
    def by_any_links(self) -> Misfit:
        """Return the misfit of any links."""
        return self.motion.any_links.misfit(self.torque)

    @property
    def by_known(self) -> Misfit:
        """Return the misfit of the declared links, of any links if those are unknown."""
        return self.by_links or self.by_any_links

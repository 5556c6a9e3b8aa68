"""Rows of the tables about what was fitted to an arm."""

from dataclasses import dataclass

from ur5lib.records.verdicts import Reason, State, Use


@dataclass(frozen=True, kw_only=True)
class RotorRow:
    """A row of rotor_inertia.csv: the inertia of a joint's rotor [kg m²], and further fitted terms
    that should be zero [Nm, Nm, Nm s/rad], with standard errors.
    """

    joint: int
    value: float
    std_error: float
    offset: float
    offset_std_error: float
    coulomb: float
    coulomb_std_error: float
    viscous: float
    viscous_std_error: float


@dataclass(frozen=True, kw_only=True)
class ParameterRow:
    """A row of parameters.csv: a base parameter of the identified model, see `BaseParameter`."""

    parameter: str
    value: float
    std_error: float
    determined: bool


@dataclass(frozen=True, kw_only=True)
class ExcitationRow:
    """A row of excitation.csv: what an arm's recordings determine, see `Excitation`; motion: the
    kind of motion that the first advice names.
    """

    combinations: int
    undetermined: int
    gravity: float | None = None
    inertia: float | None = None
    rotors: float | None = None
    all: float | None = None
    advice: str
    motion: str | None


@dataclass(frozen=True, kw_only=True)
class RemarkRow:
    """A row of remarks.csv: a remark of a fit, on a joint or the whole arm."""

    step: str
    joint: int | None = None
    remark: str
    code: str


@dataclass(frozen=True, kw_only=True)
class FrictionRow:
    """A row of friction.csv: a fitted value of a joint, as `Parameter`, or its total friction at a
    load [Nm]; known: the prior constant, contradicted: the fitted one that contradicts it; use,
    reason: whether it may be used, and why not, or with which doubt; state: the same, as that of
    verdicts.
    """

    joint: int
    parameter: str
    value: float
    std_error: float
    prior_share: float
    known: float | None = None
    known_std: float | None = None
    contradicted: float | None = None
    low: float
    high: float
    determined: bool
    arm_share: float
    day_share: float
    run_share: float
    load: float | None = None
    use: Use
    reason: Reason
    state: State


@dataclass(frozen=True, kw_only=True)
class TorqueConstant:
    """A row of torque_constants.csv: a joint's torque constant [Nm/A], with the columns of
    `FrictionRow`.
    """

    joint: int
    torque_constant: float
    std_error: float
    low: float
    high: float
    known: float | None
    known_std: float | None
    contradicted: float | None
    determined: bool
    use: Use
    reason: Reason
    state: State


@dataclass(frozen=True, kw_only=True)
class CrossValidation:
    """A row of cross_validation.csv: RMSE of a fit to one recording, tested on another [A]."""

    fitted_on: str
    tested_on: str
    joint: int
    rmse_lowpassed: float


@dataclass(frozen=True, kw_only=True)
class CalibratedQuantity:
    """A row of imu_calibration.csv: the calibration of an arm's IMU by all `fit` recordings.

    described: place by the arm's description; held_out: error on recordings left out with the
    estimated place, divided by that with the described one; below 1, the estimate is used.
    """

    quantity: str
    axis: str
    unit: str
    value: float
    std_error: float
    described: float | None = None
    held_out: float | None = None

"""The link models that were identified: rotors, and rigid bodies."""

from dataclasses import dataclass, field

from ur5lib.errors import Remark
from ur5lib.tables import BY_KEY
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class Excitation:
    """What the motion of recordings determines of an arm's parameters, at a given noise of the
    torques.

    condition: condition numbers of the regressor's columns, by group of base parameters and for
    "all"; infinite if a column is zero; combinations: number of independent combinations of the
    base parameters that are determined; undetermined: names of the base parameters that are not;
    advice: motions that would determine more, empty if everything is determined.
    """

    condition: dict[str, float]
    combinations: int
    undetermined: list[str]
    advice: list[Remark]


@dataclass(frozen=True)
class Terms:
    """The terms fitted to each joint's torque, (6,) each: inertia [kg m²], offset [Nm], coulomb
    [Nm], viscous [Nm s/rad].
    """

    inertia: Array
    offset: Array
    coulomb: Array
    viscous: Array


@dataclass(frozen=True)
class Rotors:
    """rotor_inertia.json: rotor inertias, and the terms that should be zero.

    from_: the recordings of the fit; None where no torques were recorded.
    """

    __pydantic_config__ = BY_KEY

    from_: list[str] = field(default_factory=list)
    value: Terms | None = None
    std_error: Terms | None = None


@dataclass(frozen=True)
class BaseParameter:
    """A base parameter in SI units.

    parameter: its name, with the parameters that are grouped with it; determined: whether the data
    determine it; weights: (P,), w of the sum wᵀ π over the arm's parameters π.
    """

    parameter: str
    value: float
    std_error: float
    determined: bool
    weights: Array


@dataclass(frozen=True, kw_only=True)
class Identification:
    """identification.json: the rigid bodies identified from the controller's torques.

    from_: the recordings with torques; noise: of the torques (n,) [Nm]; mae [Nm] and
    smallest_eigenvalues [kg m², kg]: (n,) each, for the fits "without constraint" and "consistent";
    refused: why nothing was identified.
    """

    __pydantic_config__ = BY_KEY

    from_: list[str] = field(default_factory=list)
    noise: Array | None = None
    parameters: list[BaseParameter] = field(default_factory=list)
    mae: dict[str, Array] = field(default_factory=dict)
    smallest_eigenvalues: dict[str, Array] = field(default_factory=dict)
    excitation: Excitation | None = None
    refused: Remark | None = None

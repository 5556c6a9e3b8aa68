"""Dynamics, friction and contact force of robot arms, from recordings.

    >>> arm = ur5lib.read_arm("ur5e")
    >>> model = ur5lib.fit(ur5lib.read(["free1.csv", "free2.csv"], arm))
    >>> forces = model.estimate(ur5lib.read("pushed.csv", arm, role="contact"))
    >>> forces.attrs["units"]["Fmap_Fx"]
    'N'

`read` gives `Recordings`, `fit` a `Model`, `load` the `FinishedStudy` of `ur5 run`, `read_arm` an
`Arm`, `load_model` a saved model: these names stay, modules may change. SI units, float64, samples
first: (N, n); each frame has its units in `attrs["units"]`. What a user can correct raises an
`InputError`. `help(ur5lib.Model)` shows what a model answers.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "1.0.0"

if TYPE_CHECKING:
    from ur5lib.chain.model import Model as Model
    from ur5lib.chain.model import fit as fit
    from ur5lib.chain.model import load_model as load_model
    from ur5lib.chain.recordings import Arm as Arm
    from ur5lib.chain.recordings import Recordings as Recordings
    from ur5lib.errors import InputError as InputError
    from ur5lib.finished import FinishedStudy as FinishedStudy
    from ur5lib.finished import load as load
    from ur5lib.importing.in_memory import read as read
    from ur5lib.importing.in_memory import read_arm as read_arm

_HOMES = {
    "Arm": "chain.recordings",
    "FinishedStudy": "finished",
    "InputError": "errors",
    "Model": "chain.model",
    "Recordings": "chain.recordings",
    "fit": "chain.model",
    "load": "finished",
    "load_model": "chain.model",
    "read": "importing.in_memory",
    "read_arm": "importing.in_memory",
}


def __getattr__(name: str) -> Any:
    """Load a public name (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module 'ur5lib' has no attribute {name!r}")
    return getattr(import_module(f"ur5lib.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*_HOMES, "__version__"])

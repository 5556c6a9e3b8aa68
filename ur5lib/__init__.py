"""Dynamics, friction and contact force of robot arms, from recordings.

    >>> arm = ur5lib.read_arm("ur5e")
    >>> model = ur5lib.fit(ur5lib.read(["free1.csv", "free2.csv"], arm))
    >>> forces = model.estimate(ur5lib.read("pushed.csv", arm, role="contact"))
    >>> forces.attrs["units"]["Fmap_Fx"]
    'N'

`read` gives `Recordings`, `fit` a `Model`, `load` the `FinishedStudy` of `ur5 run`, or of `run`,
`read_arm` an `Arm`, `load_model` a saved model; `compare` takes two models, `live` one: these names
stay, modules may change. SI units, float64, samples first: (N, n); each frame has its units in
`attrs["units"]`. Joints count from 0 in the names of columns, as in RTDE's `actual_q_0`, and from 1
in tables, text and `joint=`. What a user can correct raises an `InputError`; the logger is
`ur5lib`. `help(ur5lib.Model)` shows what a model answers.
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
    from ur5lib.chain.scorer import nrmse as nrmse
    from ur5lib.commands.run import run as run
    from ur5lib.errors import InputError as InputError
    from ur5lib.errors import RecordingWarning as RecordingWarning
    from ur5lib.finished import FinishedStudy as FinishedStudy
    from ur5lib.finished import load as load
    from ur5lib.importing.in_memory import read as read
    from ur5lib.importing.in_memory import read_arm as read_arm

_HOMES = {
    "Arm": "chain.recordings",
    "FinishedStudy": "finished",
    "InputError": "errors",
    "Model": "chain.model",
    "RecordingWarning": "errors",
    "Recordings": "chain.recordings",
    "fit": "chain.model",
    "load": "finished",
    "nrmse": "chain.scorer",
    "load_model": "chain.model",
    "read": "importing.in_memory",
    "read_arm": "importing.in_memory",
    "run": "commands.run",
}


_OF_METHODS = {"exported_model": "commands.exported_model"}  # doors that a `Model` opens


def __getattr__(name: str) -> Any:
    """Load a public name (PEP 562), or one that a topic adds."""
    if home := (_HOMES | _OF_METHODS).get(name):
        return getattr(import_module(f"ur5lib.{home}"), name)
    if not name.startswith("_") and name in (of_topics := _of_topics()):
        return of_topics[name]
    raise AttributeError(f"module 'ur5lib' has no attribute {name!r}")


def _of_topics() -> dict[str, Any]:
    from ur5lib.workspace.topics import modules_of_topics

    doors = modules_of_topics("door").values()
    return {name: own for door in doors for name, own in door.NAMES.items()}


def __dir__() -> list[str]:
    return sorted([*_HOMES, *_of_topics(), "__version__"])

"""The ten scripts of docs/api.md: the files that they name, and what each must show."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ur5lib
from tests.in_memory import FREE, put_recordings

WORN = 0.3  # A; a brake that drags on joint 4 and doubles its friction
NAMELESS = [f"actual_{name}_{k}" for name in ("q", "qd", "current") for k in range(6)]


def put_files(folder: Path) -> None:
    """Put what the scripts name: recordings, of a repaired arm and at rest, too, and a model."""
    put_recordings(folder)
    for k, name in enumerate(FREE, start=1):
        table = pd.read_csv(folder / name)
        table["actual_current_3"] += WORN * np.sign(table["actual_qd_3"])
        table.to_csv(folder / f"repaired{k}.csv", index=False)
    rest = pd.read_csv(folder / "pushed.csv")[:1]
    rest = pd.concat([rest] * 400, ignore_index=True)
    rest["timestamp"] += 0.008 * np.arange(len(rest))
    rest.to_csv(folder / "rest.csv", index=False)
    (folder / "pushed_twice.csv").write_text("no recording")
    (folder / "model.json").write_text(saved())


@cache
def saved() -> str:
    """The text of a model that was saved."""
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as name:
        folder = Path(name)
        put_recordings(folder)
        fitted_once(ur5lib.read([folder / one for one in FREE], "ur5e")).save(folder / "m.json")
        return (folder / "m.json").read_text()


FITTED = dict[tuple[str, ...], ur5lib.Model]()
FIT = ur5lib.fit


def fitted_once(runs: ur5lib.Recordings, **given: Any) -> ur5lib.Model:
    """The fit of recordings, by their names; with arguments anew."""
    key = tuple(runs.names)
    if given or key not in FITTED:
        model = FIT(runs, **given)
        return model if given else FITTED.setdefault(key, model)
    return FITTED[key]


def run_script(code: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run a script in a folder with its files, and see what it must show."""
    put_files(folder)
    monkeypatch.setattr(ur5lib, "fit", fitted_once, raising=False)
    if "sklearn" in code:  # tests/chain/test_estimator.py fits each
        monkeypatch.setattr(ur5lib.Model, "fit", lambda own, *_: _quick(own))
    known: dict[str, Any] = {"__name__": "script"}
    exec(compile(code, "script", "exec"), known)
    next(check for start, check in SCRIPTS.items() if code.startswith(start))(known)


def _quick(own: ur5lib.Model) -> ur5lib.Model:
    """The fit to all recordings, which a search takes for each of its own."""
    vars(own).update(vars(FITTED[("free1", "free2")]) | own.get_params())
    return own


def torque_of_a_motion(known: dict[str, Any]) -> None:
    assert known["torque"].shape == known["std"].shape == known["loaded"].shape == (500, 6)


def friction_in_a_loop(known: dict[str, Any]) -> None:
    friction = known["torques"] - known["single"].gravity(known["q"])
    np.testing.assert_allclose(friction, known["table"].to_numpy()[:, :6], atol=1e-9)


def arrived(known: dict[str, Any]) -> None:
    assert np.abs(known["goal"] - known["q"]).max() < 1e-3


def repaired(known: dict[str, Any]) -> None:
    assert "ur5e, joint 4, coulomb" in {*known["differences"]["name"]}


def written(known: dict[str, Any]) -> None:
    assert all(Path(file).read_text() for file in known["files"].values())


def felt(known: dict[str, Any]) -> None:
    assert known["largest"] == pytest.approx(40, abs=12)


def at_rest(known: dict[str, Any]) -> None:
    assert known["rest"].current.shape == known["rest"].qd.shape == (400, 6)
    assert known["model"].estimate(known["rest"])["hidden_x"].notna().any()


def searched(known: dict[str, Any]) -> None:
    assert known["search"].best_params_.keys() == {"cutoff_hz", "terms"}
    assert -1 < known["search"].best_score_ < 0


def of_ones_own(known: dict[str, Any]) -> None:
    assert [*known["rows"]["joint"]] == [1, 2, 3, 4, 5, 6]


def of_many(known: dict[str, Any]) -> None:
    assert [*known["largest"]] == ["pushed.csv"]


SCRIPTS: dict[str, Callable[[dict[str, Any]], None]] = {
    'import numpy as np\nimport ur5lib\n\nmodel = ur5lib.load_model("model.json")\ntime': (
        torque_of_a_motion
    ),
    'import numpy as np\nimport ur5lib\n\nmodel = ur5lib.load_model("model.json")\nsingle': (
        friction_in_a_loop
    ),
    "import numpy as np\nimport ur5lib\n\nsingle": arrived,
    "import ur5lib\n\nbefore": repaired,
    "from pathlib import Path\nimport ur5lib": written,
    'import ur5lib\n\nmodel = ur5lib.fit(ur5lib.read(["free1.csv",': felt,
    "import ur5lib\n\nfree = ": at_rest,
    "import ur5lib\nfrom sklearn": searched,
    "import numpy as np\nimport ur5lib\nfrom ur5lib.robots.friction": of_ones_own,
    "import logging": of_many,
}

"""The live estimate in copies of recordings (`ur5 convert --into`): what it would have stated."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ur5lib.chain.model import Model
from ur5lib.chain.recordings import frame_of
from ur5lib.chain.steps import Chain, Files
from ur5lib.commands.added import Added, estimate, quality, wrench_of
from ur5lib.study.selection import Selection

STEP = "estimate_live"


def known(model: Model) -> Files:
    """Return what the live estimator learnt of the model's arm, as the step reads it; empty of the
    file of a model, and of a study without it.
    """
    if isinstance(model._source, Path):
        file = model._source / "parameters" / model.robot / "live.json"
        return {"live": file} if file.is_file() else {}
    if model._source is None:
        return {}
    study = model._source.model_copy(update={"settings": model._settings})
    fitted = {name: dict(own) for name, own in model._fitted.items()}
    chain = Chain(Selection(study), model.robot, dict(model._arm), fitted, fitted)
    chain.run("fit_live")
    return {"live": chain.arm["live"]}


def channels(files: Files) -> Iterator[Added]:
    """Yield what the live estimator states of a recording, nothing where it may state none."""
    frame = frame_of(files["live_forces"])
    if "live_Fx" not in frame:
        return
    is_known = frame["known"].to_numpy(bool)
    wrench, std = (wrench_of(frame, name) for name in ("live", "live_std"))
    touched, odds = frame["contact"].to_numpy(bool), frame["evidence"].to_numpy()
    how = "by the samples before alone, as on the running arm"
    yield from estimate("live", how, wrench, std, touched & is_known, odds)
    yield quality("live", files, is_known & np.isfinite(std).all(axis=1))

"""The error of a model's currents as one number, by which scikit-learn chooses."""

from collections.abc import Sequence

import numpy as np

from ur5lib.chain.model import Model
from ur5lib.chain.recordings import Recordings, as_recordings


def nrmse(model: Model, recordings: Recordings | Sequence[Recordings], y: None = None) -> float:
    """Return the negative error of predicted currents over that of a constant current, a scorer of
    scikit-learn: the larger, the better, -1 is no better than a constant.

    Of each joint over all recordings, then the mean over joints. Unlike in `Model.score`, nothing
    is low-passed, so that fits of different cut-offs compare.

        >>> -0.3 < ur5lib.nrmse(model, runs) < 0
        True
    """
    frame = model.predict(as_recordings(recordings))
    left, measured = (frame.filter(regex=rf"^{of}_.*_\d+$") for of in ("residual", "actual"))
    ratio = left.pow(2).mean().to_numpy() / measured.var(ddof=0).to_numpy()
    return -float(np.sqrt(ratio).mean())

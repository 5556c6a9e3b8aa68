"""The public name that this topic adds to ur5lib."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ur5lib.chain.model import Model
    from ur5lib.topics.live.live import Live


def live(model: "Model", *, as_in: str = "", accept: str = "") -> "Live":
    """Return the live estimator of a model: its `step(time, q, qd, current)` gives the force.

    It is that of `model.export("live")`, whose arguments and errors it has.

        >>> estimate = ur5lib.live(model)
        >>> state = runs["free1"].device("robot").iloc[0]
        >>> q, qd, current = (
        ...     state[[f"actual_{name}_{k}" for k in range(6)]] for name in ("q", "qd", "current")
        ... )
        >>> estimate.step(0.0, q, qd, current).wrench.shape
        (6,)
    """
    from ur5lib.topics.live.live import Live, read_arm

    return Live(read_arm(model.export("live", as_in=as_in, accept=accept)))


NAMES = {"live": live}

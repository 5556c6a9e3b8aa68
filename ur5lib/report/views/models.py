"""Link models, and their torques compared with the controller's."""

import pandas as pd

from ur5lib.report.results import Results
from ur5lib.report.topics import shown_first


def compared(results: Results) -> list[str]:
    """Return the recordings that the figures of torques show: those that topics ask for, then those
    of the role `validate`; without any, one other with torque errors.
    """
    judged = [*results.tables["torque_mae"].dropna(subset="mae")["recording"].unique()]
    others = results.with_role("validate", judged)
    first = shown_first(results, "torque_mae")
    return results.shown([*first, *others]) or results.shown(judged, 1)


def torque_errors(results: Results) -> pd.DataFrame:
    """Return the torque errors of the link models on the recordings of `compared`."""
    return results.rows("torque_mae", recording=compared(results)).dropna(subset="mae")


def determined(results: Results) -> list[dict[str, object]]:
    """Return for each arm the number of determined base parameters (`count`, `of`), and whether
    measured torques determine them.
    """
    rows = results.tables["parameters"]
    return [
        {
            "robot": robot,
            "measured": robot in results.placeholders,
            "count": len(own[own["determined"] == "yes"]),
            "of": len(own),
        }
        for robot, own in rows.groupby("robot", sort=False)
    ]

"""The payload by the wrist sensor, for `ur5 payload`."""

import pandas as pd

from ur5lib.finished import StudyFiles


def masses(results: StudyFiles) -> pd.DataFrame:
    """Return the mass on the flange [kg] by recording: `value`, its interval `low` to `high`."""
    rows = results.table("audit") if "audit" in results.tables else pd.DataFrame({"quantity": []})
    return rows[rows["quantity"] == "mass"]

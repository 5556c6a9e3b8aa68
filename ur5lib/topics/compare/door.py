"""The public name that this topic adds to ur5lib."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    import pandas as pd

    from ur5lib.chain.model import Model
    from ur5lib.finished import FinishedStudy

    Compared: TypeAlias = Model | FinishedStudy | str | Path


def compare(before: "Compared", after: "Compared") -> "pd.DataFrame":
    """Return what differs between two fits, or two studies, as `ur5 compare` does.

    before, after: models, or results of studies. A row for each number that both have: `topic`,
    `name`, its values with errors as text, `before` and `after`, whether they differ by more than
    their 95 % interval, `differs`, and by more than that of all numbers of the topic, `changed`.
    Raises InputError where tables are missing.

        >>> ur5lib.compare(model, model)["changed"].any()
        False
    """
    import pandas as pd

    from ur5lib.topics.compare.comparison import CHANGE_COLUMNS
    from ur5lib.topics.compare.comparison import compare as compare_results

    with _results(before) as first, _results(after) as second:
        rows = [vars(one) for one in compare_results(first, second)]
    return pd.DataFrame(rows, columns=CHANGE_COLUMNS[1:])


def _results(given: "Compared") -> Any:
    """Return the folder of results of a model or a study, for a while."""
    from contextlib import nullcontext

    from ur5lib.chain.model import Model
    from ur5lib.commands.exported_model import results_of
    from ur5lib.finished import FinishedStudy, load

    if isinstance(given, Model):
        return results_of(given)
    return nullcontext((given if isinstance(given, FinishedStudy) else load(given)).folder)


NAMES = {"compare": compare}

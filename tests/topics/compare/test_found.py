"""What a comparison adds to the findings."""

from tests.made_study import study
from ur5lib.report.found import findings


def test_changed_numbers_are_a_finding_and_equal_ones_are_not() -> None:
    one = {"study": "before", "name": "a", "before": "1", "after": "2", "differs": "yes"}
    rows = [one | {"topic": "force", "changed": flag} for flag in ("yes", "no")]
    assert "1 of 2 numbers changed since before: force." in findings(study(changes=rows))
    assert not any("changed" in told for told in findings(study(changes=rows[1:])))

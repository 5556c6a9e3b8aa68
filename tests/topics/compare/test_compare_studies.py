"""A study beside others: in its report, and when its comparison runs again."""

import shutil
from dataclasses import replace

from tests.conftest import STUDY, Change, Workflow
from tests.made_study import study
from tests.topics.pages import section, shown
from tests.workflow.test_workflow import DOCUMENT, append
from ur5lib.tables import read_csv


def test_a_study_is_compared_with_another(workflow: Workflow) -> None:
    """With a copy of its own results: nothing has changed. Without it, the same steps run again."""
    folder = workflow.folder / "results"
    shutil.copytree(folder / "small", folder / "before")
    append(workflow.folder / "config.yaml", "compare_with: [before]\n")
    judged = {"judge_study": 1} | DOCUMENT  # which read the study
    compared = {"compare_studies": 1} | judged
    assert workflow.plan() == compared
    workflow.build("--until", "compare_studies")
    rows = read_csv(folder / "small" / "tables" / "changes.csv")
    assert {*rows["study"], *rows["changed"]} == {"before", "no"}
    assert workflow.plan() == judged
    (workflow.folder / "config.yaml").write_text(STUDY)  # by which the study was judged
    assert workflow.plan() == {"compare_studies": 1} | DOCUMENT


def test_another_comparison_repeats_nothing_else(built_workflow: Workflow, change: Change) -> None:
    change("ur5lib/topics/compare/comparison.py", "\nEDITED = True\n")
    assert built_workflow.plan() == {"compare_studies": 1} | DOCUMENT


def test_its_section_counts_what_changed_and_is_absent_without_another_study() -> None:
    one = {"study": "be_fore", "topic": "force", "name": "a", "before": "1", "after": "2"}
    rows = [one | {"differs": "yes", "changed": flag, "name": flag} for flag in ("yes", "no")]
    results = study(changes=rows)
    told = section("compare", results)
    assert "Compared with “be_fore”, 1 of 2 numbers changed: force." in told.text
    assert told.tables == {
        "counts-be_fore": [
            {"topic": "force", "compared": "2", "beyond their error": "2", "changed": "1"}
        ],
        "changed-be_fore": [{"topic": "force", "what": "yes", "before": "1", "now": "2"}],
    }
    assert "none of 1 numbers changed." in section("compare", study(changes=rows[1:])).text
    assert shown("compare", study()) is None
    tables = {name: own for name, own in results.tables.items() if name != "changes"}
    assert shown("compare", replace(results, tables=tables)) is None

"""What to record next, in the report: the bands after it, and the command that designs it."""

from dataclasses import replace
from typing import Any

import pytest

from tests.made_study import study
from tests.topics.pages import section, shown
from ur5lib.excitation.outlook import Bands
from ur5lib.report.results import Results
from ur5lib.topics.next_recordings.found import NOW
from ur5lib.topics.next_recordings.rank_recordings import with_worth
from ur5lib.topics.next_recordings.rows import RankedBands


def poorly_known(**changed: Any) -> Results:
    """A study whose joints' friction rests on others, that of joint 3 most."""
    known = {"robot": "ur5", "parameter": "coulomb", "std_error": 0.1}
    rows = [known | {"joint": k, "prior_share": k / 100} for k in range(1, 7)]
    rows[2] |= {"parameter": "load", "prior_share": 0.9}
    made = study(friction=rows)
    own = {**made.study, "study": "mine"} | changed
    return replace(made, study=own, loads={"ur5": 1.0})


def options(results: Results) -> list[str]:
    """The words of the command to be copied."""
    (command,) = section("next_recordings", results).section.iter("pre")
    words = command.text_content().split()
    assert words[:2] == ["ur5", "excite"]
    return words[2:]


def test_what_to_record_next_names_what_is_known_least_and_the_command() -> None:
    told = section("next_recordings", poorly_known()).text
    assert (
        "least (± half of its 95 % interval; share of its variance that rests on other arms): "
        "load friction of joint 3 (± 0.2, 90 %), Coulomb friction of joint 6 (± 0.2, 6 %), "
        "Coulomb friction of joint 5 (± 0.2, 5 %)."
    ) in told
    assert "Mount the known load, here 1 kg next to the axis of joint 6" in told
    words = options(poorly_known())
    assert words[words.index("--results") + 1] == "results/mine"
    assert words[words.index("--robot") + 1] == "ur5"
    assert words[words.index("--payload") + 1] == "1"
    assert words[words.index("--question") + 1] == "undetermined"


def test_the_command_knows_the_table_below_the_arm() -> None:
    words = options(poorly_known(devices={"table_m": -0.8}))
    assert words[words.index("--table") + 1] == "-0.8"


@pytest.mark.parametrize(("force", "worth"), [(9.6, "no"), (9.1, "no"), (9.0, "yes")])
def test_a_recording_is_worthwhile_that_narrows_the_band_of_a_force_by_a_tenth(
    force: float, worth: str
) -> None:
    best = Bands("with 2 kg", force, 0.1, 0.1)
    _, ranked = with_worth([Bands(NOW, 10.0, 0.1, 0.1), best])
    assert ranked == RankedBands(**vars(best), worthwhile=worth)


def ranked(worth: str) -> Results:
    rows = [("now", 10.0), ("slowly", 9.7), ("with 2 kg", 9.0)]
    known = {"robot": "ur5", "current": 0.1, "mass": 0.1, "worthwhile": worth}
    return study(next_recordings=[known | {"after": after, "force": f} for after, f in rows])


def test_the_recording_that_narrows_forces_most_is_named_with_all_bands() -> None:
    told = section("next_recordings", ranked("yes"))
    assert "Record with ur5: with 2 kg. That narrows" in told.text
    assert "from ± 10 to ± 9 N (Table" in told.text
    rows = told.tables["next-recordings"]
    assert [row["force in contact [N]"] for row in rows] == ["10", "9.7", "9"]


def test_where_none_is_worthwhile_the_report_says_what_limits() -> None:
    told = section("next_recordings", ranked("no"))
    assert "by less than a tenth: from ± 10 to ± 9 N at best" in told.text
    assert "untouched" in told.text
    assert told.tables == {}
    assert len(section("next_recordings", ranked("no"), "details").tables["next-recordings"]) == 3


def test_its_section_is_absent_without_a_fit_or_its_table() -> None:
    results = study()
    tables = {name: own for name, own in results.tables.items() if name != "next_recordings"}
    for page in ("report", "details"):
        assert shown("next_recordings", results, page) is None
        assert shown("next_recordings", replace(results, tables=tables), page) is None

"""What to record next, in the report: the bands after it, and the command that designs it."""

from dataclasses import replace

import pandas as pd
import pytest

from tests.made_study import study
from tests.topics.pages import shown
from ur5lib.excitation.outlook import Bands
from ur5lib.report.page.compose import shown_table
from ur5lib.report.results import Results
from ur5lib.report.views.first_screen import next_steps
from ur5lib.topics.next_recordings.found import NOW
from ur5lib.topics.next_recordings.rank_recordings import with_worth
from ur5lib.topics.next_recordings.report import designs, limits
from ur5lib.topics.next_recordings.rows import RankedBands


def test_what_to_record_next_names_what_is_known_least_and_the_command() -> None:
    known = {"robot": "ur5", "parameter": "coulomb", "std_error": 0.1}
    rows = [known | {"joint": k, "prior_share": k / 100} for k in range(1, 7)]
    rows[2] |= {"parameter": "load", "prior_share": 0.9}
    results = study()
    tables = {**results.tables, "friction": pd.DataFrame(rows)}
    (told,) = designs(Results({"study": "mine"}, tables, loads={"ur5": 1.0}))
    least = {3: 90, 6: 6, 5: 5}  # shares of the prior [%] by joint, the largest first
    places = [told.index(f"friction of joint {k} (± 0.1, {s} %)") for k, s in least.items()]
    assert places == sorted(places)
    assert told.count("± 0.1,") == len(places)
    words = told.partition("ur5 excite ")[2].partition("”")[0].split()
    options = [word for word in words if word.startswith("--")]
    assert words[words.index("--results") + 1] == "results/mine"
    assert options == ["--robot", "--results", "--question", "--payload", "--table", "--output"]
    assert words[words.index("--table") + 1] == "0"
    assert words[words.index("--payload") + 1] == "1.0"
    on_pedestal = {"study": "mine", "devices": {"table_m": -0.8}}
    (told,) = designs(Results(on_pedestal, tables))
    assert "--table -0.8 " in told


@pytest.mark.parametrize(("force", "worth"), [(9.6, "no"), (9.1, "no"), (9.0, "yes")])
def test_a_recording_is_worthwhile_that_narrows_the_band_of_a_force_by_a_tenth(
    force: float, worth: str
) -> None:
    best = Bands("with 2 kg", force, 0.1, 0.1)
    _, ranked = with_worth([Bands(NOW, 10.0, 0.1, 0.1), best])
    assert ranked == RankedBands(**vars(best), worthwhile=worth)


@pytest.mark.parametrize(("worth", "told"), [("no", []), ("yes", ["10 to ± 9 N"])])
def test_the_recording_that_narrows_forces_most_is_a_step(worth: str, told: list[str]) -> None:
    force = 9.0
    rows = [("now", 10.0), ("slowly", 9.7), ("with 2 kg", force)]
    known = {"robot": "ur5", "current": 0.1, "mass": 0.1, "worthwhile": worth}
    tables = {"next_recordings": [known | {"after": after, "force": f} for after, f in rows]}
    steps = [step for step in next_steps(study(**tables)) if "with 2 kg" in step]
    assert len(steps) == len(told)
    assert all(one in step for one, step in zip(told, steps, strict=True))
    assert len(shown_table("next_recordings", study(**tables)).rows) == 3 * len(told)
    assert [f"± 10 to ± {force:g} N at best" in one for one in limits(study(**tables))] == (
        [] if told else [True]
    )
    assert shown("next_recordings", study(**tables)) == (["TableBlock"] if told else ["Items"])


def test_its_section_is_empty_without_a_fit_or_its_table() -> None:
    results = study()
    assert shown("next_recordings", results) == []
    tables = {name: own for name, own in results.tables.items() if name != "next_recordings"}
    assert shown("next_recordings", replace(results, tables=tables)) == []
    assert next_steps(replace(results, tables=tables)) == next_steps(results)

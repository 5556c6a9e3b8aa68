"""Sentences: templates in one file."""

import math
import re

import pytest

from tests.conftest import PROJECT
from ur5lib.errors import remark
from ur5lib.records.wording import WORDS, in_words, sentence, templates
from ur5lib.report.page import sentences
from ur5lib.report.page.document import DeclaredTable, contents
from ur5lib.report.page.formats import between, rounded, with_error, within
from ur5lib.report.page.sentences import say
from ur5lib.strict import read_yaml

REPORT = PROJECT / "ur5lib" / "report"
NAMES, TOPICS = sentences._written()
DEFINED = {f"{topic}.{name}" for topic, texts in TOPICS.items() for name in texts}
OF_TOPICS = PROJECT / "ur5lib" / "topics"
MODULES = *REPORT.rglob("*.py"), *OF_TOPICS.rglob("*.py")
CODE = "".join(path.read_text() for path in MODULES)


def test_a_number_below_its_bound_is_not_zero() -> None:
    assert rounded(0.03, 0, "%") == "< 1 %"


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (1814.842, 221.09, "1810 ± 220"),
        (240.319, 21.684, "240 ± 22"),
        (8.146, 0.604, "8.15 ± 0.60"),
        (0.05, 0.00996, "0.050 ± 0.010"),
        (1.04, 3.5e-4, "1.04000 ± 0.00035"),
        (283.564, math.nan, "284"),
        (1e-9, 0.0, "< 0.0001"),
        (math.nan, 1.0, "–"),
    ],
)
def test_two_digits_of_the_error_decide_how_a_value_is_shown(
    value: float, std: float, text: str
) -> None:
    assert with_error(value, std) == text


@pytest.mark.parametrize(
    ("value", "low", "high", "text"),
    [
        (7.2512, 2.3, 11.9, "7.3"),
        (3.39, 2.1, 5.4, "3.39"),
        (0.04031, 0.04030, 0.04032, "0.0403"),
        (7.2512, None, None, "7.25"),
        (7.2512, math.nan, math.nan, "7.25"),
        (3, None, None, "3"),
    ],
)
def test_a_value_has_no_more_decimals_than_its_interval_tells(
    value: float, low: float | None, high: float | None, text: str
) -> None:
    assert within(value, low, high) == text


@pytest.mark.parametrize(
    ("low", "high", "value", "text"),
    [
        (7.2, 16.4, 11.1, "11 (7–16)"),
        (0.61, 190.0, math.nan, "1–190"),
        (10697.0, 15286.0, 12950.0, "13000 (11000–15000)"),
        (4.8, 14, 8.3, "8.3 (4.8–14.0)"),
    ],
)
def test_the_ends_of_an_interval_have_as_many_decimals(
    low: float, high: float, value: float, text: str
) -> None:
    assert between(low, high, value) == text


@pytest.mark.parametrize(
    ("seconds", "text"), [(1.5e-8, "0.000000015"), (12345.0, "12300"), (2.0, "2")]
)
def test_no_number_of_a_finding_has_an_exponent(seconds: float, text: str) -> None:
    assert f" {text} s " in f"{sentence('bytes skipped', {'seconds': seconds})} "


def test_a_value_that_a_template_lacks_is_an_error() -> None:
    with pytest.raises(sentences.jinja2.UndefinedError):
        say("findings.load")


def test_every_sentence_exists_and_is_said() -> None:
    named = re.findall(r'"([a-z_]+)\.([a-z ]+)"', CODE)
    tables = {one.table for one in contents().blocks() if isinstance(one, DeclaredTable)}
    said = {f"{topic}.{name}" for topic, name in named if topic in TOPICS} - tables
    asked = re.findall(r'\bsay\(\s*"([a-z_]+)\.([a-z ]+)"', CODE)
    assert said | {f"{topic}.{name}" for topic, name in asked} <= DEFINED
    chosen = re.findall(r'f"([a-z]+)\.\{', CODE)  # by their reason or kind
    assert {name for name in DEFINED - said if name.split(".")[0] not in chosen} == set()


def test_every_topic_of_names_is_used() -> None:
    files = *(REPORT / "page").glob("*.yaml"), *OF_TOPICS.glob("*/report.yaml")
    used = "".join(path.read_text() for path in files)
    named = {topic for topic in NAMES if f"name('{topic}')" in used or f'names("{topic}")' in CODE}
    assert named == {*NAMES}


# Findings and remarks


def test_every_remark_has_a_sentence_and_every_sentence_its_remark() -> None:
    library = "".join(path.read_text() for path in (PROJECT / "ur5lib").rglob("*.py"))
    stated = r'\b(?:remark|contradiction|RefusalError|ContradictionError)\(\s*"([^"]+)"'
    assert {*re.findall(stated, library)} <= templates().keys()
    assert [code for code in templates() if f'"{code}"' not in library] == []


def test_a_sentence_stands_beside_the_module_that_writes_its_code() -> None:
    """And once."""
    places = [*(PROJECT / "ur5lib").rglob(WORDS)]
    assert len(places) > 40
    for place in places:
        module = place.with_name(place.name.replace(".words.yaml", ".py"))
        code = module.read_text()
        assert [one for one in read_yaml(place) if f'"{one}"' not in code] == [], place
    assert sum(len(read_yaml(place)) for place in places) == len(templates())


def test_remarks_stand_in_the_sentences_of_others() -> None:
    reasons = [remark("negative weight", mass=-0.3, std=0.02), remark("other reason", reason="so")]
    found = in_words(remark("turned sensor", reasons=reasons))
    assert found.startswith(
        "the weight of the sensor's tool points upwards (−0.3 ± 0.02 kg) and so: "
    )


def test_a_list_of_numbers_is_as_a_study_writes_it() -> None:
    assert (
        in_words(remark("mounting as cause", value=[0.0, 0.0, -9.81])) == "`gravity: [0, 0, -9.81]`"
    )


def test_one_joint_is_no_joints() -> None:
    told = [in_words(remark("missing load", arm="ur5", joints=some)) for some in ([4], [2, 3])]
    assert "joint 4 of ur5" in told[0]
    assert "joints 2, 3 of ur5" in told[1]


def test_a_number_that_json_does_not_know_is_unknown() -> None:
    known = remark("other constant", joint=3, fitted=None, known=9.5, unit="Nm/A")
    assert in_words(known) == "joint 3 with unknown instead of 9.5 Nm/A"


def test_a_number_without_bounds_has_four_digits() -> None:
    """Torques beside a column of zeros differ by any share."""
    for share, said in ((1e300, "above 9999%"), (math.inf, "above 9999%"), (0.4, "40%")):
        text = in_words(remark("other torque", arm="ur5", share=share))
        assert f"differs from the torque of ur5 by {said} of its size" in text
    text = in_words(remark("implausible clock", apart_s=-2e7, drift=-0.5))
    assert "a start below −9999 s from the start stamps and a drift of −50.00%" in text

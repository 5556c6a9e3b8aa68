"""Sentences of findings, remarks and steps: one for each code, beside the module that writes it."""

import math
import re
from importlib import import_module
from pathlib import Path

import pytest

from tests.conftest import PROJECT
from ur5lib.errors import remark
from ur5lib.records.wording import WORDS, in_words, sentence, templates
from ur5lib.strict import read_yaml


@pytest.mark.parametrize(
    ("seconds", "text"), [(1.5e-8, "0.000000015"), (12345.0, "12300"), (2.0, "2")]
)
def test_no_number_of_a_finding_has_an_exponent(seconds: float, text: str) -> None:
    assert f" {text} s " in f"{sentence('bytes skipped', {'seconds': seconds})} "


def test_a_value_that_a_sentence_lacks_is_an_error() -> None:
    with pytest.raises(KeyError, match="seconds"):
        sentence("bytes skipped", {})


def test_every_remark_has_a_sentence() -> None:
    library = "".join(path.read_text() for path in (PROJECT / "ur5lib").rglob("*.py"))
    stated = r'\b(?:remark|contradiction|RefusalError|ContradictionError)\(\s*"([^"]+)"'
    assert {*re.findall(stated, library)} <= templates().keys()


def test_a_sentence_lies_beside_the_module_that_writes_its_code() -> None:
    """And once."""
    places = [*(PROJECT / "ur5lib").rglob(WORDS)]
    assert len(places) > 40
    for place in places:
        module = place.with_name(place.name.replace(".words.yaml", ".py"))
        assert [code for code in read_yaml(place) if not writes(module, code)] == [], place
    assert sum(len(read_yaml(place)) for place in places) == len(templates())


def writes(module: Path, code: str) -> bool:
    """Whether a module contains a code, an f-string that may be it, or a constant that is."""
    text = module.read_text()
    parts = (re.split(r"\{[^}]*\}", found) for found in re.findall(r'\bf"([^"]*)"', text))
    composed = (".+".join(map(re.escape, own)) for own in parts if len(own[0]) > 4)
    if f'"{code}"' in text or any(re.fullmatch(own, code) for own in composed):
        return True
    name = ".".join(module.relative_to(PROJECT).with_suffix("").parts)
    return code in [own for own in vars(import_module(name)).values() if isinstance(own, str)]


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

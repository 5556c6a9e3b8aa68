"""Sentences of findings, remarks and steps: one for each code, beside the module that writes it."""

import re
from importlib import import_module
from pathlib import Path

from tests.conftest import PROJECT
from ur5lib.errors import remark
from ur5lib.records.wording import WORDS, in_words, templates
from ur5lib.strict import read_yaml


def test_every_remark_has_a_sentence() -> None:
    library = "".join(path.read_text() for path in (PROJECT / "ur5lib").rglob("*.py"))
    stated = r'\b(?:remark|RefusalError|ContradictionError)\(\s*"([^"]+)"'
    assert {*re.findall(stated, library)} <= templates().keys()


def test_a_sentence_lies_beside_the_module_that_writes_its_code() -> None:
    """And once."""
    places = [*(PROJECT / "ur5lib").rglob(WORDS)]
    assert places
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

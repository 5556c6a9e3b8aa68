"""Numbers as text: digits by their errors, no exponents, no minus before zero."""

import json
from pathlib import Path
from typing import Any

import pytest
import typst

from tests.conftest import PROJECT

KIT = PROJECT / "ur5lib" / "report" / "page" / "kit"
CASES: list[tuple[str, str]] = [
    ("fixed(-0.04, digits: 1)", "0.0"),
    ("fixed(-3.25, digits: 1)", "−3.3"),
    ("fixed(none)", "–"),
    ("fixed(1234567.0)", "1,234,567"),
    ('fixed(12.0, digits: 2, unit: "N")', "12.00 N"),
    ("fixed(123.4, digits: -1)", "120"),
    ("bounded(0.0004, 2)", "< 0.01"),
    ('measured(0.000004, unit: "Nm")', "< 0.0001 Nm"),
    ("measured(0.03817)", "0.0382"),
    ("measured(9.996)", "10.0"),
    ("measured(262.4)", "262"),
    ("measured(5)", "5"),
    ("measured(none)", "–"),
    ("significant(0.07706, 2)", "0.077"),
    ("significant(100.0, 3)", "100"),
    ("significant(2.50, 3)", "2.5"),
    ("significant(6.748e-21, 3)", "0"),  # the mean load of an upright axis
    ("significant(-3e-300, 2)", "0"),
    ('within(3.389, 2.06, 5.40, unit: "N")', "3.4 N"),
    ("within(93.1, 33.9, 152.3)", "93"),
    ("within(0.0381, 0.0317, 0.0446)", "0.038"),
    ("within(5.0, none, 7.0)", "5.00"),
    ("interval(2.06, 5.40)", "2.1 to 5.4"),
    ("interval(3.01, 3.04)", "3.0"),
    ("with-error(9.932, 0.99)", "9.93 ± 0.99"),
    ("with-error(-120.4, 44.0)", "−120 ± 44"),
    ("with-error(5.2, none)", "5.20"),
    ("with-error(0.249, 0.0206)", "0.249 ± 0.021"),
    ("signed(0.004, digits: 1)", "0.0"),
    ("signed(2.0, digits: 1)", "+2.0"),
    ("percent(0.155)", "16 %"),
    ("power(12345.0, digits: 3)", "1.23·10⁴"),
    ("power(0.00001234, digits: 3)", "1.23·10⁻⁵"),
    ("power(0.5, digits: 3)", "0.5"),
    ("power(0)", "0"),
    ("joints((2.0,))", "joint 2"),
    ("joints((1, 3))", "joints 1 and 3"),
    ("joints((1, 2, 3, 5, 4, 6))", "joints 1 to 6"),
    ('counted(1, "contact")', "1 contact"),
    ('counted(0, "contact")', "0 contacts"),
    ('day("2026-11-07T12:00")', "7 November 2026"),
    ('each((1.0, none, -2.26), digits: 1, unit: "N")', "1.0, –, −2.3 N"),
]


@pytest.fixture(scope="module")
def texts(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """All cases at once: Typst starts once."""
    root: Path = tmp_path_factory.mktemp("numbers")
    (root / "kit").symlink_to(KIT)
    lines = [f"#metadata({case}) <case>" for case, _ in CASES]
    (root / "main.typ").write_text("\n".join(['#import "/kit/numbers.typ": *', *lines]))
    found: Any = typst.query(root / "main.typ", "<case>", field="value", root=root)
    return [str(text).replace("\u00a0", " ") for text in json.loads(found)]


@pytest.mark.parametrize("number", range(len(CASES)), ids=[case for case, _ in CASES])
def test_a_number_reads_as_a_scientist_writes_it(texts: list[str], number: int) -> None:
    assert texts[number] == CASES[number][1]

"""The numbers of a page that are rows of verdicts.csv, each read against its row."""

import re
from collections.abc import Iterator
from typing import Any

import pandas as pd
from lxml.html import HtmlElement

from tests.typeset_page import plain

NUMBER = re.compile(r"(<\s*)?([+−-]?)(\d[\d,]*(?:\.\d+)?)")
WORDS_OF_SIGN = {  # below and above the middle, where a number is best
    "error": (0.0, "too small", "too large"),
    "change": (0.0, "lower", "higher"),
    "ratio": (1.0, "too small", "too large"),
}
ASIDE = re.compile(r"\(?before: .*|\([^()]*: [^()]*\)")  # what a number was, or is compared with
COUNTED = re.compile(r"^([^,]*?[a-rt-z])s\b")
# Numbers that no row of verdicts.csv has: joints, recordings, shares that intervals are for.
NAMES = re.compile(
    r"\bR\d+\b|\bur\d+\w*|\bjoints? \d+(?:(?:, | and | to )\d+)*|95 %|\b[12]:1\b|F̂\S*|±"
)


def checked(page: HtmlElement, verdicts: pd.DataFrame) -> int:
    """The number of numbers on a page that are those of their rows.

    Raises AssertionError for one with another value, unit, label, sign or whole, and for one in a
    first sentence or card that no row has.
    """
    found = [*page.xpath("//*[@data-line]")]
    for element in found:
        row = verdicts.iloc[int(element.get("data-line")) - 2]
        check_number(element, {name: value for name, value in row.items() if pd.notna(value)})
    for place in page.xpath("//p[@class='headline'] | //div[@class='cards']//p[@class='said']"):
        assert not re.search(r"\d", NAMES.sub("", outside(place))), plain(place.text_content())
    return len(found)


def outside(place: HtmlElement) -> str:
    """The text of an element without its numbers of rows, and the labels of its card's number."""
    text = plain(place.text_content())
    for own in place.xpath(".//*[@data-line]"):
        text = text.replace(plain(own.text_content()), "", 1)
    return re.sub(r"^[^.]*?below \d+(?:\.\d+)? Hz|of \d+(?:\.\d+)? s |with \d+ %", "", text)


def check_number(element: HtmlElement, row: dict[str, Any]) -> None:
    own = plain(element.text_content())
    around = plain(surrounding(element).text_content()).lower()
    label = str(row.get("quantity", ""))
    if column := element.get("data-column"):
        value, rival = NUMBER.search(own.rpartition(": ")[2]), str(row.get("rival", ""))
        assert value is not None, own
        assert is_near(value, row[column]), (own, row)
        assert own.endswith(str(row.get("unit", ""))), (own, row)
        assert column != "rival_value" or rival.lower() in own.lower(), (own, row)
    else:
        assert any(one.lower() in around for one in spellings(label, row)), (own, label)
        stated = without(own, spellings(label, row))
        assert has_the_value(stated, row), (own, row)
        check_signs(stated, row)


def surrounding(element: HtmlElement) -> HtmlElement:
    """What has the label of a number: its card, or its sentence, or what its heading opens."""
    if element.tag == "p":
        return next(element.iterancestors("article"))
    inner, outer = (element.iterancestors(*tags) for tags in (("li", "td", "p"), ("details",)))
    return [*inner, *outer, element][0]


def spellings(label: str, row: dict[str, Any]) -> Iterator[str]:
    """A label, of one thing, and of none."""
    yield label
    if row.get("count") == 1:
        yield COUNTED.sub(r"\1", label)
    if row.get("count") == 0:
        yield label.removesuffix(", the largest")


def without(text: str, labels: Iterator[str]) -> str:
    """A text without a label, whose digits are no value."""
    for label in labels:
        text = re.sub(re.escape(label), "", text, flags=re.IGNORECASE)
    return ASIDE.sub("", text)


def has_the_value(text: str, row: dict[str, Any]) -> bool:
    """Whether a text states the number of a row: its count and whole, its value with the unit."""
    numbers = [*NUMBER.finditer(text)]
    unit = str(row.get("unit", ""))
    expected = [row[name] for name in ("count", "of") if name in row]
    if "value" in row and "of" in row and "count" in row:
        expected.append(row["value"])
    elif "value" in row:
        expected = [row["value"]]
    elif not expected:
        expected = [row[name] for name in ("low", "high") if name in row]
    else:
        unit = ""
    if len(numbers) < len(expected) or ("of" in row and "count" in row and " of " not in text):
        return False
    shown = numbers[: len(expected)]
    near = all(is_near(one, value) for one, value in zip(shown, expected, strict=True))
    after = text[shown[-1].end() :].strip()
    ends = re.match(r"\w", after[len(unit) :]) is None
    return near and (not unit or (after.startswith(unit) and ends))


def is_near(found: re.Match[str], value: float) -> bool:
    """Whether digits are a number, rounded to them; of "< 0.1", whether it is less."""
    below, sign, digits = found.groups()
    stated = float(digits.replace(",", "")) * (-1 if sign in ("−", "-") else 1)
    if below:
        return abs(value) <= stated
    step = 10.0 ** -len(digits.partition(".")[2])
    return abs(stated - value) <= 0.5001 * step


def check_signs(text: str, row: dict[str, Any]) -> None:
    middle, below, above = WORDS_OF_SIGN.get(str(row.get("sense", "")), (0.0, "", ""))
    low, high = row.get("low", middle), row.get("high", middle)
    if row.get("interval") == "95 %" and low < middle < high:
        assert not below or (below not in text and above not in text), (text, row)
    elif below and row.get("value", middle) != middle:
        if row["sense"] == "ratio" and row["value"] < 0:
            below = "of opposite sign"
        right, wrong = (below, above) if row["value"] < middle else (above, below)
        assert right in text, (text, row)
        assert wrong not in text, (text, row)

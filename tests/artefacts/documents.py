"""What every report must be, as HTML in a browser and as PDF, whatever its study."""

import html
import json
import re
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pypdfium2
import pypdfium2.raw as raw
import pytest
from lxml.html import HtmlElement, fromstring
from pypdf import PdfReader

from ur5lib.channels import CURRENT, TORQUE
from ur5lib.report.page.sentences import names, speaking_of, spoken
from ur5lib.tables import read_csv

WIDE, NARROW, HEIGHT = 1200, 390, 900  # pixels
VIEWS = ((WIDE, "light"), (WIDE, "dark"), (NARROW, "light"))
MARGIN = 14  # mm, left and right of the text on A4
POINTS = 72 / 25.4  # in a millimetre
SLACK = 6  # points: punctuation hangs out
LEAST_LETTERS = 8  # points in the PDF
LEAST_FIGURE = 700  # pixels of a figure on a phone, whose letters then are 10 pixels high
# Replays that are open from the start are there, so that nothing moves while Axe looks.
OPENED = """[...document.querySelectorAll("button.look[aria-expanded=true]")].every(
    one => one.closest("figure").querySelector(".closer"))"""
LABEL = re.compile(r"<!-- (.*?) -->")  # of a letter, a number or a line in an SVG
DASHES = re.compile(r"stroke-dasharray: [\d.]")
SAID_OF_LABELS = {  # of captions: what stands in a legend by other words
    "Pale:": "unfiltered",
    "Grey: near a singularity": "near a singularity",
    "Hatched: gap": "gap",
    "95 % band": "95 % band",
}
TOUCH = 2  # points by which letters of neighbours may reach into each other


@contextmanager
def browser() -> Iterator[Any]:
    """Chromium, where it is installed."""
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("Chromium is not installed: the report was not opened in a browser")
    playwright = pytest.importorskip("playwright.sync_api")
    flags = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=program, args=flags)
        yield opened
        opened.close()


def check_in_browser(report: Path, folder: Path, views: Sequence[tuple[int, str]] = VIEWS) -> None:
    """It reads on wide and narrow screens, light and dark, and prints to A4."""
    from axe_playwright_python.sync_playwright import Axe

    with browser() as chromium:
        for width, scheme in views:
            page = chromium.new_page(
                viewport={"width": width, "height": HEIGHT}, color_scheme=scheme
            )
            told: list[str] = []
            page.on("console", lambda message: told.append(message.text))  # noqa: B023
            page.on("request", lambda request: told.append(request.url))  # noqa: B023
            page.goto(report.as_uri())
            beyond = [line for line in told if not line.startswith(("data:", report.as_uri()))]
            assert beyond == [], "messages, or requests beyond the file"
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            if width == NARROW:
                check_on_a_phone(page)
            page.wait_for_function(OPENED)
            violations = Axe().run(page).response["violations"]
            assert [(v["id"], v["nodes"][0]["html"][:200]) for v in violations] == []
            if (width, scheme) == views[0]:
                page.pdf(path=str(folder / "print.pdf"), prefer_css_page_size=True)
            page.close()
    check_margins(folder / "print.pdf", MARGIN)


def check_on_a_phone(page: Any) -> None:
    """Captions are visible as a whole, figures as wide as one can read; headers leave room."""
    right = "all => all.map(one => one.getBoundingClientRect().right)"
    for whole in (".drawing", "figcaption", "caption div"):
        assert max(page.eval_on_selector_all(whole, right)) <= NARROW, whole
    shown = ".drawing:not(.replaced) img"
    widths = page.eval_on_selector_all(shown, "all => all.map(one => one.clientWidth)")
    assert min(widths, default=LEAST_FIGURE) >= LEAST_FIGURE
    scrolled = """all => all.filter(one => {
        const around = one.closest(".scroll");
        return around.scrollWidth > around.clientWidth;
    }).map(one => one.getBoundingClientRect().right)"""
    headers = page.eval_on_selector_all(".scroll tbody th:first-child", scrolled)
    assert headers
    assert max(headers) <= NARROW / 2


def check_structure(report: Path) -> None:
    """One h1, headings in order, words for every image, headers for every table."""
    text = report.read_text()
    levels = [int(level) for level in re.findall(r"<h([1-6])", text)]
    assert levels.count(1) == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))
    images = re.findall(r"<img [^>]*>", text)
    assert images
    assert all(re.search(r' alt="[^"]{20,}"', image) for image in images)
    for table in re.findall(r"<table>.*?</table>", text, re.DOTALL):
        assert "<caption>" in table
        assert '<th scope="col"' in table
        assert '<th scope="row"' in table


def check_captions(report: Path) -> None:
    """Captions and alternative texts name what is drawn, and links of names, and nothing else."""
    page = fromstring(report.read_text())
    for table in page.iter("table"):
        if "linked name" in table.find("caption").text_content():
            assert table.xpath(".//tbody//th/a")
    for figure in page.iter("figure"):
        if not (sources := figure.xpath(".//figcaption//a[starts-with(@href, 'figures/')]/@href")):
            continue
        text = f"{figure.find('.//figcaption').text_content()} {figure.find('.//img').get('alt')}"
        text = text.replace("\u00a0", " ")
        svg = (report.parent / sources[0]).with_suffix(".svg").read_text()
        drawn = LABEL.findall(svg[svg.index('id="legend') :]) if 'id="legend' in svg else []
        if figure.get("data-recording"):  # over time
            said = text.casefold()
            assert [one for one in drawn if html.unescape(one).casefold() not in said] == [], (
                sources
            )
            for word, label in SAID_OF_LABELS.items():
                assert (word in text) == (label in drawn), (sources, word)
        dashes = {"dashed", "dotted"} & {*re.findall(r"\w+", text)}
        is_image = "<image" in svg  # of so many points that lines are part of it
        assert not dashes or is_image or DASHES.search(svg), sources


def check_results(folder: Path) -> None:
    """results.json fits its schema and says what the report's first screen says."""
    told, schema = (
        json.loads((folder / name).read_text()) for name in ("results.json", "results.schema.json")
    )
    jsonschema.validate(told, schema)
    assert told["$schema"] == "results.schema.json"
    page = html.unescape((folder / "report.html").read_text())
    text = re.sub("</?code>", "`", page.replace("\u00a0", " ").replace("<wbr>", ""))
    cards = dict(re.findall(r"<h3>(.*?) <span class=\"state\">(.*?)</span>", text))
    rows = read_csv(folder / "tables" / "verdicts.csv")
    assert len(told["verdicts"]) == len(rows)
    judged = rows[(rows["rank"] == 1) & rows["state"].notna()]
    by_title = dict(titles(judged["question"].unique()))
    for title, state in cards.items():
        own = judged[judged["question"] == by_title[title]]
        of_study = own[own["arm"].isna()]
        assert [state] == [*(of_study if len(of_study) else own)["state"]], title
    assert len(cards) == judged["question"].nunique()
    listed = [sentence for one in told["lists"] for sentence in one["sentences"]]
    assert [one["heading"] for one in told["lists"]][:2] == ["What to do next", "Findings"]
    for sentence in listed:
        assert sentence.replace("\u00a0", " ") in text
    for row in told["verdicts"]:
        if row["interval"]:
            assert row["low"] <= row["value"] <= row["high"]


def titles(questions: Iterable[str]) -> Iterator[tuple[str, str]]:
    """The titles of cards with their questions, of arms with currents and with torques."""
    for effort in (CURRENT, TORQUE):
        with speaking_of(effort):
            yield from ((spoken(names("question").get(one, one)), one) for one in questions)


def check_links(folder: Path) -> None:
    """Whatever the pages link to is there, with its place."""
    pages = {name: (folder / name).read_text() for name in ("report.html", "details.html")}
    places = {name: {*re.findall(r'\bid="([^"]+)"', text)} for name, text in pages.items()}
    for name, text in pages.items():
        linked = re.findall(r'(?:href|src)="((?!data:|https?:)[^"]+)"', text)
        assert linked
        for file, _, place in (one.partition("#") for one in linked):
            assert (folder / file).exists(), file
            assert not place or place in places[file or name], f"{file}#{place}"


def check_digits(texts: Iterable[str]) -> None:
    """No number has an exponent or no meaning; one and its error have the same decimals, and no
    line breaks between them.
    """
    number = r"(?<![\w.])\d[\d,]*(?:\.(\d+))?"
    for text in texts:
        assert not re.search(r"\bnan\b|\binf\b|\bNone\b|\d[eE][-+−]\d|± ?<|[ \n]±\d", text), text
        assert not re.search(r"\d ±|± \d|\d %", text), f"{text}: may break within a number"
        for decimals in re.findall(rf"{number}\u00a0±\u00a0{number}", text):
            assert len({*map(len, decimals)}) == 1, text


def shown_texts(page: Path) -> list[str]:
    """The texts of a page: paragraphs, items, cells, captions and numbers of cards."""
    kinds = ["p", "li", "td", "th", "dd", "dt", "figcaption", "caption", "h2", "h3"]
    return [one.text_content() for one in fromstring(page.read_text()).iter(*kinds)]


def stated(text: str) -> list[float]:
    """Return the numbers of a text in their order; of “joints 2 to 5” also those between."""
    digits = re.sub(r"(?<=\d),(?=\d{3})", "", text).replace("−", "-")
    found: list[float] = []
    for low, high, value in re.findall(r"joints (\d) to (\d)|(?<![\w.])(-?\d+(?:\.\d+)?)", digits):
        found += range(int(low), int(high) + 1) if low else [float(value)]
    return found


def page_texts(report: Path) -> list[str]:
    """The text of each page, in one line."""
    pages = pypdfium2.PdfDocument(report)
    return [" ".join(page.get_textpage().get_text_range().split()) for page in pages]


def check_pdf(report: Path, sections: list[str]) -> None:
    """Contents, bookmarks, numbered and mentioned figures and tables, fonts, margins."""
    reader = PdfReader(report)
    texts = page_texts(report)
    assert "Contents" in texts[0]
    bookmarks = [entry.title for entry in reader.outline if not isinstance(entry, list)]
    assert [title for title in sections if not any(title in known for known in bookmarks)] == []
    whole = " ".join(texts)
    for kind in ("Table", "Figure"):
        captions = {int(number) for number in re.findall(rf"{kind} (\d+): ", whole)}
        assert captions == set(range(1, len(captions) + 1))
        mentions = {int(number) for number in re.findall(rf"{kind} (\d+)(?!\d|: )", whole)}
        assert captions - mentions == set(), f"{kind}s that no text mentions"
    for page in reader.pages:
        for font in page["/Resources"].get("/Font", {}).values():
            embedded = font.get_object().get("/DescendantFonts", [font])[0].get_object()
            described = embedded["/FontDescriptor"].get_object()
            assert {"/FontFile", "/FontFile2", "/FontFile3"} & set(described)
    check_margins(report, MARGIN)
    check_overlaps(report)
    check_letters(report)


def check_margins(document: Path, margin: float) -> None:
    """No text stands out to the side of any page: no table is cut."""
    for number, page in enumerate(pypdfium2.PdfDocument(document), start=1):
        text = page.get_textpage()
        right = page.get_width() - margin * POINTS
        for i in range(text.count_rects()):
            left, _, end, _ = text.get_rect(i)
            assert left >= margin * POINTS - SLACK, f"page {number}"
            assert end <= right + SLACK, f"page {number}"


def check_letters(document: Path) -> None:
    """No letters are too small to read."""
    for number, page in enumerate(pypdfium2.PdfDocument(document), start=1):
        text = page.get_textpage()
        letters = enumerate(text.get_text_range(errors="replace"))
        sizes = [raw.FPDFText_GetFontSize(text, i) for i, one in letters if not one.isspace()]
        assert min(sizes, default=LEAST_LETTERS) > LEAST_LETTERS - 0.01, f"page {number}"


def check_overlaps(document: Path) -> None:
    """No text stands upon other text: no column is narrower than its words."""
    for number, page in enumerate(pypdfium2.PdfDocument(document), start=1):
        text = page.get_textpage()
        boxes = np.array([text.get_rect(i) for i in range(text.count_rects())])
        starts, ends = boxes[:, :2], boxes[:, 2:]
        common = np.minimum(ends[:, None], ends) - np.maximum(starts[:, None], starts)
        height = ends[:, 1] - starts[:, 1]
        over = (common[..., 0] > TOUCH) & (common[..., 1] > np.minimum.outer(height, height) / 2)
        words = [text.get_text_bounded(*boxes[i]) for i in np.argwhere(np.triu(over, 1))[:, 0]]
        assert words == [], f"page {number}"


def cells_of(page: HtmlElement, words: str) -> list[list[str]]:
    """The rows of the table with these words in its caption."""
    [table] = [own for own in page.iter("table") if words in own.find("caption").text_content()]
    return [[cell.text_content() for cell in row.iter("td", "th")] for row in table.iter("tr")]

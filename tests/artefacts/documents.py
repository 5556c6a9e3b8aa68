"""What every report must be, as HTML in a browser and as PDF, whatever its study."""

import html
import json
import re
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from copy import deepcopy
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import html5lib
import jsonschema
import numpy as np
import pandas as pd
import pypdfium2
import pypdfium2.raw as raw
import pytest
from lxml.html import HtmlElement, fromstring
from pypdf import PdfReader
from pypdf.generic import DictionaryObject

from tests.numbers_of_a_page import checked
from tests.typeset_page import plain
from ur5lib.records.verdicts import STATES, state_in_words
from ur5lib.report.page.handed import WORDS
from ur5lib.tables import read_csv

WIDE, NARROW, HEIGHT = 1280, 390, 900  # pixels
CAPTIONS = {"Figure": "//figcaption", "Table": "//*[starts-with(@id, 'caption-')]"}
VIEWS = ((WIDE, "light"), (WIDE, "dark"), (NARROW, "light"))
MARGIN = 14  # mm, left and right of the text on A4
POINTS = 72 / 25.4  # in a millimetre
SLACK = 6  # points: punctuation hangs out
LEAST_LETTERS = 8  # points in the PDF
LEAST_FIGURE = 700  # pixels of a figure on a phone, whose letters then are 10 pixels high
MOST_BYTES = 2_000_000  # of a page
MOST_WORDS = {"first sentence": 25, "card": 20, "first screen": 400}
MOST_NUMBERS = 4  # of the first sentence
# Replays that are open from the start are there, so that nothing moves while Axe looks.
OPENED = """() => [...document.querySelectorAll("button.look[aria-expanded=true]")].every(
    one => one.closest("figure").querySelector(".closer"))"""
LEAST_ON_SCREEN = 10  # pixels of letters in a chart
LETTERS = """all => all.map(one => {
    const chart = one.closest("svg");
    const scale = chart.getBoundingClientRect().width / chart.viewBox.baseVal.width;
    return scale * one.getAttribute("font-size");
})"""
LABEL = re.compile(r"<!-- (.*?) -->")  # of a letter, a number or a line in an SVG
DASHES = re.compile(r"stroke-dasharray: [\d.]")
SAID_OF_LABELS = {  # of captions: what stands in a legend by other words
    "Pale:": "unfiltered",
    "Grey: near a singularity": "near a singularity",
    "Hatched: gap": "gap",
    "95 % band": "95 % band",
}
NUMBER = re.compile(r"([<>]?)\s*([−-]?\d[\d,]*(?:\.(\d+))?)")  # bound, value, its decimals
NAMED = re.compile(r'#let (id|topic) = "([\w-]+)"')
AWAY = re.compile("data:|https?:|mailto:")
CARDS = ".//*[@data-question]"
LOADED_MS = 180_000  # a busy machine takes 40 s for the demo's report, an idle one 3 s
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
    """It reads on wide and narrow screens, light and dark, and prints to A4, and asks nobody for
    anything.
    """
    with browser() as chromium:
        for width, scheme in views:
            page = opened(chromium, report, width, scheme)
            assert page.evaluate("() => document.documentElement.scrollWidth") <= width
            if width == NARROW:
                check_on_a_phone(page)
            if (width, scheme) == views[0]:
                page.pdf(path=str(folder / "print.pdf"), prefer_css_page_size=True)
            page.close()
            check_access(chromium, report, width, scheme)
    check_margins(folder / "print.pdf", MARGIN)


def opened(chromium: Any, report: Path, width: int, scheme: str) -> Any:
    """A page under its security policy, without messages, or requests beyond the file."""
    page = chromium.new_page(viewport={"width": width, "height": HEIGHT}, color_scheme=scheme)
    told: list[str] = []
    page.on("console", lambda message: told.append(message.text))
    page.on("pageerror", lambda error: told.append(str(error)))
    page.on("request", lambda request: told.append(request.url))
    page.goto(report.as_uri(), timeout=LOADED_MS)
    page.wait_for_function(OPENED)
    assert [one for one in told if not one.startswith(("data:", report.as_uri()))] == []
    return page


def check_access(chromium: Any, report: Path, width: int, scheme: str) -> None:
    """Axe finds nothing; it is injected, which the page's own policy forbids."""
    from axe_playwright_python.sync_playwright import Axe

    context = chromium.new_context(
        viewport={"width": width, "height": HEIGHT}, color_scheme=scheme, bypass_csp=True
    )
    page = context.new_page()
    page.goto(report.as_uri(), timeout=LOADED_MS)
    page.wait_for_function(OPENED)
    violations = Axe().run(page).response["violations"]
    assert [(v["id"], v["nodes"][0]["html"][:200]) for v in violations] == []
    context.close()


def check_on_a_phone(page: Any) -> None:
    """Captions are visible as a whole, figures as wide as one can read; headers leave room."""
    right = "all => all.map(one => one.getBoundingClientRect().right)"
    for whole in (".drawing", "figcaption", "caption div"):
        assert max(page.eval_on_selector_all(whole, right)) <= NARROW, whole
    shown = ".drawing:not(.replaced) img"
    widths = page.eval_on_selector_all(shown, "all => all.map(one => one.clientWidth)")
    assert min(widths, default=LEAST_FIGURE) >= LEAST_FIGURE
    letters = page.eval_on_selector_all(".chart text", LETTERS)
    assert min(filter(None, letters), default=LEAST_ON_SCREEN) > LEAST_ON_SCREEN - 0.5
    scrolled = """all => all.filter(one => {
        const around = one.closest(".scroll");
        return around.scrollWidth > around.clientWidth;
    }).map(one => one.getBoundingClientRect().right)"""
    headers = page.eval_on_selector_all(".scroll tbody th:first-child", scrolled)
    assert headers
    assert max(headers) <= NARROW / 2


def check_structure(report: Path) -> None:
    """One h1, headings in order, words for every picture, headers for every table; figures and
    tables are numbered, and called by their numbers.
    """
    page = fromstring(report.read_text())
    levels = [int(one.tag[1]) for one in page.iter("h1", "h2", "h3", "h4", "h5", "h6")]
    assert levels.count(1) == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))
    assert page.xpath("//img | //svg")
    assert all(len(one) >= 20 for one in page.xpath("//img/@alt | //svg/@aria-label"))
    assert not page.xpath(
        "//img[not(@alt)] | //svg[not(@aria-label)]"
        " | //svg[not(@role='img')][not(.//a[@aria-label])]"
    )
    for table in page.iter("table"):
        assert table.find("caption") is not None
        assert table.xpath(".//th[@scope='col']")
        assert table.xpath(".//th[@scope='row']")
    ids = page.xpath("//@id")
    assert len(ids) == len({*ids})
    check_numbering(page)


def check_numbering(page: HtmlElement) -> None:
    """From one on, in the order of the page; a link to one says its number."""
    for kind, captions in CAPTIONS.items():
        texts = [plain(one.text_content()) for one in page.xpath(captions)]
        assert [text.split(". ")[0] for text in texts] == [
            f"{kind} {number}" for number in range(1, len(texts) + 1)
        ]
        assert all(len(text.split()) > 4 for text in texts)
    for link in page.xpath("//a[starts-with(@href, '#')]"):
        if re.fullmatch(r"(Table|Figure) \d+", text := plain(link.text_content())):
            shown = link.get("href")[1:]
            [caption] = page.xpath(
                "//*[@id=$name]//figcaption | //*[@id=concat('caption-', $name)]", name=shown
            )
            assert plain(caption.text_content()).startswith(f"{text}. ")


def check_captions(report: Path) -> None:
    """Captions and alternative texts name what is drawn, and links of names, and nothing else."""
    page = fromstring(report.read_text())
    for table in page.iter("table"):
        [caption] = page.xpath("//*[@id=$name]", name=table.getparent().get("aria-labelledby"))
        if "linked name" in caption.text_content():
            assert table.xpath(".//tbody//th/a")
    for figure in page.iter("figure"):
        sources = figure.xpath(".//figcaption//a[contains(@href, 'figures/')]/@href")
        if not sources or not (pictures := figure.xpath(".//img/@alt")):
            continue  # drawn from rows by the page itself
        text = plain(f"{figure.find('.//figcaption').text_content()} {pictures[0]}")
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


def check_results(folder: Path, least: int = 30) -> None:
    """results.json fits its schema; it and the report's first screen say what verdicts.csv says."""
    told, schema = (
        json.loads((folder / name).read_text()) for name in ("results.json", "results.schema.json")
    )
    jsonschema.validate(told, schema)
    assert told["$schema"] == "results.schema.json"
    page = fromstring((folder / "report.html").read_text())
    check_found(told, page)
    verdicts = read_csv(folder / "tables" / "verdicts.csv")
    assert checked(page, verdicts) > least
    rows = verdicts.astype(object).where(verdicts.notna(), None)
    assert len(told["verdicts"]) == len(rows)
    for row, cells in zip(told["verdicts"], rows.to_dict("records"), strict=True):
        assert "before" in row
        assert {name: row[name] or None for name in cells} == {
            name: cell or None for name, cell in cells.items()
        }
        if row["interval"] and row["value"] is not None:
            assert row["low"] <= row["value"] <= row["high"]
    tried = read_csv(folder / "tables" / "pushes.csv")["largest_tried"]
    cards = page.xpath(CARDS)
    assert cards
    for card in cards:
        own = rows[rows["question"] == card.get("data-question")]
        if own.empty:  # two cards of one question, as of contacts and their peaks
            [line, *_] = card.xpath(".//@data-line")
            own = rows[rows["question"] == rows["question"][int(line) - 2]]
        check_state(shown_state(card), own)
        check_numbers(shown_number(card), own, tried)
    check_contents(page, rows)


def check_found(told: dict[str, Any], page: HtmlElement) -> None:
    """The first screen has each next step, finding and result that is not possible, as stated."""
    [first] = page.xpath("//section[@class='first']")
    text = plain(first.text_content())
    steps = [(one["sentence"], one["command"]) for one in told["next"]]
    for sentence in (*sum(steps, ()), *told["findings"], *told["left_out"]):
        assert plain(sentence.replace("`", "")) in text
    assert len(steps) <= 3
    assert all(sentence.startswith(sentence[0].upper()) for sentence, _ in steps)


def check_state(state: str | None, own: pd.DataFrame) -> None:
    """A card's state is the one that decides its question: on the study, if there is one."""
    first = own[own["rank"] == own["rank"].min()]
    of_study = first[first["arm"].isna()]
    assert len(first)
    deciding = {*(of_study if len(of_study) else first)["state"]}
    words = {
        state_in_words(one, own["question"].iloc[0]) if one in STATES else one for one in deciding
    }
    assert state in words, first


def check_numbers(text: str, own: pd.DataFrame, tried: pd.Series) -> None:
    """Each number is a cell as rounded, of its unit; own: the verdicts on its question; tried:
    pushes.
    """
    for counted in re.findall(r"(\d+) of (\d+)", text):
        assert (*map(int, counted),) in {*zip(own["count"], own["of"], strict=True)}, text
    same = own[[isinstance(unit, str) and text.endswith(unit) for unit in own["unit"]]]
    cells = [*same[["value", "low", "high"]].to_numpy(float).ravel(), *tried]
    cells += [*own[["count", "of"]].to_numpy(float).ravel()]
    for bound, digits, decimals in NUMBER.findall(text):
        value = float(digits.replace(",", "").replace("−", "-"))
        off = np.abs(np.array(cells) - value)
        if bound == "<":
            assert np.nanmin(np.abs(cells)) < value, text
        else:
            assert np.nanmin(off) <= 0.5001 * 10.0 ** (rounded_off(digits) - len(decimals)), text


def rounded_off(digits: str) -> int:
    """How many zeros end a large whole number, of which three digits are shown."""
    return len(digits) - len(digits.rstrip("0")) if len(digits) > 3 and "." not in digits else 0


def shown_state(one: HtmlElement) -> str | None:
    """The state on a card's badge, without its sign and its reason."""
    badges = one.xpath("(.//h3 | .//summary)[1]//span[starts-with(@class, 'badge')]")
    return plain("".join(badges[0].xpath("text()"))) if badges else None


def shown_number(card: HtmlElement) -> str:
    """The number of a card with its unit; of one in brief, what stands after title and badge."""
    if numbers := card.xpath("p[@class='number']/b | p[@class='number']/span[@class='unit']"):
        return " ".join(plain(one.text_content()) for one in numbers)
    return plain("".join(card.xpath("summary/text()")[1:]))


def check_contents(page: HtmlElement, rows: pd.DataFrame) -> None:
    """A section's state in the contents is the one that decides its question."""
    named = [dict(NAMED.findall(path.read_text())) for path in WORDS]
    topics = {one["id"]: one["topic"] for one in named if "topic" in one}
    for link in page.xpath("//nav//a[span[starts-with(@class, 'badge')]]"):
        question = topics[link.get("href")[1:]]
        check_state(link.find("span").get("title"), rows[rows["question"] == question])


def check_brief(report: Path) -> None:
    """One sees at a glance: few words before what to do next, one number and sentence a card."""
    page = fromstring(report.read_text())
    for sentence in page.xpath("//p[@class='headline']"):
        text = plain(sentence.text_content())
        assert len(words(text)) <= MOST_WORDS["first sentence"], text
        assert len(NUMBER.findall(re.sub(r" of \d+", "", text))) <= MOST_NUMBERS, text
    cards = page.xpath("//article[@data-question]")
    assert cards
    for card in cards:
        [number], [sentence] = (card.xpath(f"p[@class='{name}']") for name in ("number", "said"))
        range_or_number = re.sub(r" to (> )?\S+$", "", plain(number.find("b").text_content()))
        assert len(NUMBER.findall(range_or_number)) == 1
        assert len(words(sentence.text_content())) <= MOST_WORDS["card"], sentence.text_content()
        assert len(card.xpath("svg")) <= 1
    shown = words(unfolded(page))
    assert len(shown) <= MOST_WORDS["first screen"], f"{len(shown)} words"


def words(text: str) -> list[str]:
    """The words and numbers of a text."""
    return [one for one in plain(text).split() if any(map(str.isalnum, one))]


def unfolded(page: HtmlElement) -> str:
    """The visible text of a report from its title to the heading “What to do next”."""
    [main] = deepcopy(page).xpath("//main")
    [next_steps] = main.xpath(".//section[@class='first']/h3[.='What to do next']")
    after = next_steps.xpath("self::* | following-sibling::* | ../following-sibling::*")
    folded = main.xpath(".//details[not(@open)]/node()[not(self::summary)]")
    unseen = main.xpath(".//*[self::svg or self::script or self::nav or @class='unseen']")
    for one in (*after, *folded, *unseen):
        if isinstance(one, HtmlElement):
            one.drop_tree()
        elif one.is_tail:
            one.getparent().tail = None
        else:
            one.getparent().text = None
    return " ".join(main.itertext())


def check_valid(page: Path) -> None:
    """HTML without an error, and no larger than one sends."""
    html5lib.HTMLParser(strict=True).parse(page.read_text(encoding="utf-8"))
    assert page.stat().st_size <= MOST_BYTES


def check_links(folder: Path) -> None:
    """Whatever the pages link to is there, with its place."""
    paths = [*folder.glob("*.html"), *folder.glob("runs/*.html")]
    assert {"report.html", "details.html"} <= {path.name for path in paths}
    pages = {path.resolve(): fromstring(path.read_text()) for path in paths}
    for path, page in pages.items():
        linked = [one for one in page.xpath("//@href | //@src") if not AWAY.match(one)]
        assert linked
        for file, _, place in (one.partition("@")[0].partition("#") for one in linked):
            target = (path.parent / file).resolve() if file else path
            assert target.exists(), file
            assert not place or pages[target].xpath("//*[@id=$name]", name=place), f"{file}#{place}"


def check_digits(texts: Iterable[str]) -> None:
    """No number has an exponent or no meaning; one and its error have the same decimals, and no
    line breaks between them.
    """
    number = r"(?<![\w.])\d[\d,]*(?:\.(\d+))?"
    for text in texts:
        assert not re.search(
            r"\bnan\b|\binf\b|\bNone\b(?! of)|\d[eE][-+−]\d|± ?<|[ \n]±\d", text
        ), text
        assert not re.search(r"\d ±|± \d|\d %", text), f"{text}: may break within a number"
        for decimals in re.findall(rf"{number}\u00a0±\u00a0{number}", text):
            assert len({*map(len, decimals)}) == 1, text


def shown_texts(page: Path) -> list[str]:
    """The texts of a page: paragraphs, items, cells, captions and numbers of cards."""
    kinds = ["p", "li", "td", "th", "dd", "dt", "figcaption", "caption", "summary"]
    kinds += ["h2", "h3"]
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


def check_pdf(folder: Path) -> None:
    """The report as PDF/UA: contents and bookmarks of its sections, numbered and mentioned figures
    and tables, fonts, margins.
    """
    report = folder / "report.pdf"
    reader, texts = PdfReader(report), page_texts(report)
    assert "<pdfuaid:part>1</pdfuaid:part>" in reader.xmp_metadata.rdf_root.toxml()
    page = fromstring((folder / "report.html").read_text())
    sections = [plain(one.text_content()) for one in page.xpath("//h2[not(@class='unseen')]")]
    assert [entry.title for entry in reader.outline if not isinstance(entry, list)] == sections
    assert [title for title in sections if title not in texts[0]] == []
    whole = " ".join(texts)
    for kind, captions in CAPTIONS.items():
        named = [int(number) for number in re.findall(rf"{kind} (\d+)(?!\d|\.\d)", whole)]
        expected = {*range(1, len(page.xpath(captions)) + 1)}
        assert expected - {*named} == set(), f"{kind}s that are not there"
        of_first_screen = len(page.xpath("//section[@class='first']//figure")) * (kind == "Figure")
        unmentioned = [n for n in expected if n > of_first_screen and named.count(n) < 2]
        assert unmentioned == [], f"{kind}s that no text mentions"
    for own in reader.pages:
        for font in cast(DictionaryObject, own["/Resources"]).get("/Font", {}).values():
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
    """No letters are too small to read, as they are printed."""
    for number, page in enumerate(pypdfium2.PdfDocument(document), start=1):
        text = page.get_textpage()
        letters = enumerate(text.get_text_range(errors="replace"))
        sizes = [printed_size(text, i) for i, one in letters if not one.isspace()]
        assert min(sizes, default=LEAST_LETTERS) > LEAST_LETTERS - 0.05, f"page {number}"


def printed_size(text: Any, place: int) -> float:
    """The size of a letter in points, of one in a picture as that is scaled."""
    matrix = raw.FS_MATRIX()
    raw.FPDFText_GetMatrix(text, place, matrix)
    scale = abs(matrix.a * matrix.d - matrix.b * matrix.c) ** 0.5
    return float(raw.FPDFText_GetFontSize(text, place) * scale)


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


def cells_of(page: HtmlElement, name: str) -> list[list[str]]:
    """The rows of the table of this name, the first of headings."""
    [table] = page.xpath("//*[@id=$name]//table", name=name)
    return [
        [plain(cell.text_content()) for cell in row.iter("td", "th")] for row in table.iter("tr")
    ]

"""The documents as a site: every page, link, picture and name of the reference is there."""

import html
import re
import subprocess
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest
from lxml.html import HtmlElement, fromstring

from tests.artefacts.documents import AWAY, HEIGHT, NARROW, WIDE, browser
from tests.conftest import PROJECT
from tests.workflow.test_make import own_environment
from ur5lib import load
from ur5lib.finished import FinishedStudy
from ur5lib.force.estimators import Run
from ur5lib.records.motion import Motion
from ur5lib.robots.description import Robot
from ur5lib.robots.friction import Term

PAGES = PROJECT / ".site" / "html"
LEAST_LETTERS = 20  # of the words for a picture
OF_THE_THEME = "404.html"


@pytest.fixture(scope="module", autouse=True)
def built() -> subprocess.CompletedProcess[str]:
    make = ["make", "--old-file=.venv/dev", "--silent", "docs"]
    return subprocess.run(
        make, cwd=PROJECT, text=True, capture_output=True, check=False, env=own_environment()
    )


def words(text: str) -> set[str]:
    return {*html.unescape(text).split()}


def own_pages() -> list[Path]:
    """The documents; reports are looked at in tests of their own."""
    found = [page for page in PAGES.rglob("*.html") if "reports" not in page.parts]
    return [page for page in sorted(found) if page.name != OF_THE_THEME]


@cache
def parsed(page: Path) -> HtmlElement:
    return fromstring(page.read_text(encoding="utf-8"))


def test_the_site_is_built_without_a_warning(built: subprocess.CompletedProcess[str]) -> None:
    assert built.returncode == 0, built.stderr
    assert built.stdout.splitlines() == ["site: .site/html/index.html"]
    assert built.stderr == ""
    reference = (PAGES / "docs" / "api.html").read_text()
    for name in ("load", "FinishedStudy", "load_robot", "build_arm", "inverse_dynamics", "Stated"):
        assert f">{name}</span>" in reference, name
    shown = words(re.sub(r"<[^>]*>", "", reference))
    methods = [own for kind in (FinishedStudy, Robot) for own in vars(kind).items()]
    public = [own.__doc__ or "" for name, own in methods if name[0] != "_" and callable(own)]
    whole = [own.__doc__ or "" for own in (load, FinishedStudy, Robot, Run, Term, Motion)]
    written = words(" ".join([*public, *whole]).replace("`", ""))
    assert written - shown == set()  # no word is lost on the way, as a <placeholder> may be
    assert "str | Path" in html.unescape(re.sub(r"<[^>]*>", "", reference))  # signatures have types
    assert (PAGES / "search.json").stat().st_size > 100_000


def test_every_page_is_in_the_navigation() -> None:
    listed = (PROJECT / "mkdocs.yml").read_text()
    for page in (PROJECT / "docs").glob("*.md"):
        assert f"docs/{page.name}" in listed


def test_every_link_leads_to_a_file_and_a_place_in_it() -> None:
    """Of documents and reports."""
    broken = []
    for page in PAGES.rglob("*.html"):
        for link in parsed(page).xpath("//*[not(self::script)]/@href | //@src"):
            target, _, anchor = unquote(link).partition("@")[0].partition("#")  # a second
            led = (page.parent / target).resolve() if target else page
            if AWAY.match(link) or page.name == OF_THE_THEME:
                continue
            names = parsed(led).xpath("//@id | //a/@name") if led.suffix == ".html" else []
            if not led.exists() or (anchor and led.suffix == ".html" and anchor not in names):
                broken.append(f"{page.relative_to(PAGES)}: {link}")
    assert broken == []


def test_every_picture_says_what_it_shows() -> None:
    for page in own_pages():
        for image in parsed(page).xpath("//article//img"):
            assert len(image.get("alt", "")) >= LEAST_LETTERS, (page.name, image.get("src"))


def test_what_a_picture_shows_is_read_below_it() -> None:
    """Once: where the text says it, there is no other caption."""
    page = parsed(PAGES / "docs" / "methods.html")
    for image in page.xpath("//article//p/img"):
        below = image.getparent().getnext().text_content()
        assert " ".join(below.split()) == " ".join(image.get("alt").split())
    assert not parsed(PAGES / "index.html").xpath("//em[@aria-hidden]")


def test_the_notebook_is_a_page() -> None:
    page = parsed(PAGES / "docs" / "notebook.html")
    assert len(page.xpath("//article//pre")) > 20
    assert len(page.xpath("//article//img")) >= 2


@pytest.mark.thorough
@pytest.mark.parametrize(("width", "scheme"), [(WIDE, "light"), (NARROW, "dark")])
def test_every_page_can_be_read_by_all(width: int, scheme: str) -> None:
    """By Axe, and without a page wider than the screen."""
    from axe_playwright_python.sync_playwright import Axe

    with browser() as chromium:
        size: Any = {"width": width, "height": HEIGHT}
        context = chromium.new_context(viewport=size, color_scheme=scheme)
        for path in own_pages():
            page = context.new_page()
            page.goto(path.as_uri())
            page.wait_for_selector("body")
            assert page.evaluate("document.documentElement.scrollWidth") <= width, path.name
            violations = Axe().run(page).response["violations"]
            told = [(v["id"], v["nodes"][0]["html"][:200]) for v in violations]
            assert told == [], path.name
            page.close()

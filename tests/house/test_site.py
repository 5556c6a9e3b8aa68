"""The documents as a site: every page, link and name of the reference is there."""

import html
import re
import subprocess

from tests.conftest import PROJECT
from tests.workflow.test_make import own_environment
from ur5lib import load
from ur5lib.finished import FinishedStudy
from ur5lib.force.estimators import Run
from ur5lib.records.motion import Motion
from ur5lib.robots.description import Robot
from ur5lib.robots.friction import Term

PAGES = PROJECT / ".site" / "html"


def words(text: str) -> set[str]:
    return {*html.unescape(text).split()}


def test_the_site_is_built_without_a_warning() -> None:
    make = ["make", "--old-file=.venv/dev", "--silent", "docs"]
    done = subprocess.run(
        make, cwd=PROJECT, text=True, capture_output=True, check=False, env=own_environment()
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == ["site: .site/html/index.html"]
    assert done.stderr == ""
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

"""The documents as a site: every page, link and name of the reference is there."""

import subprocess

from tests.conftest import PROJECT
from tests.workflow.test_make import own_environment

PAGES = PROJECT / ".site" / "html"


def test_the_site_is_built_without_a_warning() -> None:
    make = ["make", "--old-file=.venv/dev", "--silent", "docs"]
    done = subprocess.run(
        make, cwd=PROJECT, text=True, capture_output=True, check=False, env=own_environment()
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == ["site: .site/html/index.html"]
    assert "WARNING" not in done.stderr
    reference = (PAGES / "docs" / "api.html").read_text()
    for name in ("load", "FinishedStudy", "load_robot", "build_arm", "inverse_dynamics", "solved"):
        assert f">{name}</span>" in reference, name
    assert (PAGES / "search" / "search_index.json").stat().st_size > 100_000


def test_every_page_is_in_the_navigation() -> None:
    listed = (PROJECT / "mkdocs.yml").read_text()
    for page in (PROJECT / "docs").glob("*.md"):
        assert f"docs/{page.name}" in listed

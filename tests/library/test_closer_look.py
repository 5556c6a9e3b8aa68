"""The closer look at figures over time: what is packed for it, and what its script does."""

import json
import re
import zlib
from base64 import b64decode
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.artefacts.documents import browser
from ur5lib.report.figures.charts import response_panel
from ur5lib.report.figures.house_style import JOINT_COLOURS, save
from ur5lib.report.figures.traces import (
    CURRENT_PANELS,
    WRENCH_PANELS,
    Panel,
    Traces,
    draw_traces,
)
from ur5lib.report.page.document import Document, Picture, Section
from ur5lib.report.page.render import LINE_LEVELS, html_page, packed_lines
from ur5lib.tables import read_csv, write_text

LENGTH = 60.0  # s
FRAME = 1000 / 60  # ms


def drawn(path: Path, panels: list[Panel], style: str = "first") -> Path:
    """A figure of a minute with a gap."""
    time = np.linspace(0, LENGTH, 30_000)
    time[9000:9010] = np.nan
    measured = np.outer(np.sin(time), np.arange(1.0, 7.0))
    series = {"sensor, raw": (measured, "measured"), "estimate": (0.9 * measured, style)}
    band = (measured - 1, measured + 1) if panels is WRENCH_PANELS else None
    save(draw_traces(Traces(time, series, band=band), panels), path)
    return path


def unpacked(text: str) -> tuple[dict[str, Any], np.ndarray, np.ndarray]:
    """The head, the times (N,) and the columns (M, N), as the script reads them."""
    line, _, content = zlib.decompress(b64decode(text)).partition(b"\n")
    head = json.loads(line)
    codes = np.frombuffer(content, np.uint8).reshape(2, -1).T.copy().view("<u2").astype(int)
    levels = np.cumsum(np.where(codes % 2, -(codes + 1) // 2, codes // 2).reshape(
        len(head["ranges"]), -1), axis=1)  # fmt: skip
    low, high = np.array(head["ranges"]).T[..., None]
    values = low + (levels - 1) / (head["levels"] - 1) * (high - low)
    times = np.cumsum([step or 0 for step in head["steps"]]) / 1000
    return head, times, np.where(levels == 0, np.nan, values)


@pytest.fixture(scope="module")
def figures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    drawn(folder / "forces.svg", WRENCH_PANELS)
    drawn(folder / "currents.svg", CURRENT_PANELS, "joint")
    return folder


def test_lines_are_packed_within_half_a_level(figures: Path) -> None:
    path = figures / "forces.svg"
    data = read_csv(path.with_suffix(".csv"))
    head, times, columns = unpacked(packed_lines(path))
    assert head["panels"][0] == ["Fx", "N"]
    assert [line["label"] for line in head["lines"]] == ["sensor, raw", "estimate"]
    assert head["band"]
    known = data["time [s]"].notna().to_numpy()
    assert np.abs(times - data["time [s]"])[known].max() < 5.01e-4
    assert [step is not None for step in head["steps"]] == known.tolist()
    told = data[[name for name in data if name != "time [s]"]].to_numpy().T
    assert (np.isnan(columns) == np.isnan(told)).all()
    worst = np.nanmax(np.abs(columns - told), axis=1)
    assert (worst <= 0.51 * np.ptp(told[:, known], axis=1) / (LINE_LEVELS - 1)).all()


def test_colours_of_a_figure_over_time_are_kept_and_others_have_no_closer_look(
    figures: Path, tmp_path: Path
) -> None:
    head, *_ = unpacked(packed_lines(figures / "currents.svg"))
    assert [line["colours"] for line in head["lines"]] == [["#000000"], [*JOINT_COLOURS[:6]]]
    save(response_panel(np.arange(1.0, 9.0), {"a": np.ones(8)}), tmp_path / "filters.svg")
    save(draw_traces(Traces(np.arange(3.0), {}), CURRENT_PANELS), tmp_path / "empty.svg")
    assert [packed_lines(tmp_path / f"{name}.svg") for name in ("filters", "empty")] == ["", ""]


@pytest.fixture(scope="module")
def report(figures: Path) -> Path:
    words = "Force and estimate along x, y, z over a minute."
    forces, currents = figures / "forces.svg", figures / "currents.svg"
    pictures = [
        Picture("Forces.", forces, words, "forces", "a.csv", "draw", "pushed"),
        Picture("Currents.", currents, words, "currents", "b.csv", "draw", "pushed"),
        Picture("Others.", currents, words, "others", "b.csv", "draw", "still"),
    ]
    document = Document("Report", "Of a test.", [Section("Figures", [*pictures])]).numbered()
    write_text(html_page(document), figures / "report.html")
    return figures / "report.html"


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as opened:
        yield opened


@pytest.fixture
def page(chromium: Any, report: Path) -> Iterator[Any]:
    page = chromium.new_page(viewport={"width": 1200, "height": 900})
    told: list[str] = []
    page.on("console", lambda message: told.append(message.text))
    page.on("pageerror", lambda error: told.append(str(error)))
    page.on("request", lambda request: told.append(request.url))
    page.goto(report.as_uri())
    yield page
    page.close()
    assert [line for line in told if not line.startswith(("data:", report.as_uri()))] == []


def opened(page: Any, name: str) -> Any:
    """The canvas of a figure."""
    page.click(f"#{name} .look")
    page.wait_for_selector(f"#{name} canvas")
    return page.locator(f"#{name} canvas")


def shown(page: Any, name: str) -> tuple[float, float]:
    """The stretch of time that a figure says it shows [s]."""
    text = page.text_content(f"#{name} [role=status]")
    start, end = re.findall(r"[\d.]+(?= s\b)", text)[:2]
    return float(start), float(end)


def test_keys_zoom_and_move(page: Any) -> None:
    canvas = opened(page, "forces")
    canvas.press("+")
    assert shown(page, "forces") == pytest.approx((6, 54), abs=0.01)
    canvas.press("ArrowLeft")
    assert shown(page, "forces") == pytest.approx((1.2, 49.2), abs=0.01)
    canvas.press("-")
    canvas.press("-")
    canvas.press("ArrowRight")
    assert shown(page, "forces") == pytest.approx((0, LENGTH), abs=0.01)
    canvas.press("+")
    canvas.press("Escape")
    assert shown(page, "forces") == pytest.approx((0, LENGTH), abs=0.01)


def test_a_drag_shows_a_stretch(page: Any) -> None:
    box = opened(page, "forces").bounding_box()
    page.mouse.move(box["x"] + 150, box["y"] + 60)
    page.mouse.down()
    page.mouse.move(box["x"] + 250, box["y"] + 60)
    page.mouse.up()
    start, end = shown(page, "forces")
    assert 0 < start < end < LENGTH / 2
    page.mouse.dblclick(box["x"] + 200, box["y"] + 60)
    assert shown(page, "forces") == pytest.approx((0, LENGTH), abs=0.01)


def test_the_values_at_the_cursor_are_told(page: Any) -> None:
    """Fx is sin t, nz six times that; an estimate is nine tenths of it."""
    box = opened(page, "forces").bounding_box()
    page.mouse.move(box["x"] + 150, box["y"] + 60)
    page.keyboard.press("+")
    text = page.text_content("#forces [role=status]")
    (time,) = map(float, re.findall(r"At ([\d.]+) s", text))
    for panel, factor in (("Fx", 1.0), ("nz", 6.0)):
        numbers = re.findall(rf"{panel} (\S+), (\S+) N", text)[0]
        sensor, estimate = (float(number.replace("−", "-")) for number in numbers)
        assert sensor == pytest.approx(factor * np.sin(time), abs=0.06 * factor)
        assert estimate == pytest.approx(0.9 * sensor, abs=0.02 * factor)


def test_figures_of_one_recording_move_together(page: Any) -> None:
    """Figures of another do not."""
    for name in ("currents", "others"):
        opened(page, name)
    opened(page, "forces").press("+")
    page.press("#currents canvas", "+")
    page.press("#others canvas", "+")
    assert shown(page, "currents") == pytest.approx((10.8, 49.2), abs=0.01)
    assert shown(page, "others") == pytest.approx((6, 54), abs=0.01)


def test_lines_and_panels_can_be_hidden(page: Any) -> None:
    canvas = opened(page, "forces")
    height = canvas.bounding_box()["height"]
    for label in ("estimate", "Fx", "nx"):
        page.uncheck(f"#forces label:has-text('{label}') input")
    canvas.press("+")
    text = page.text_content("#forces [role=status]")
    assert "Fx" not in text
    assert re.search(r"Fy \S+ N;", text)  # of the sensor alone
    assert canvas.bounding_box()["height"] < height


def test_the_picture_comes_back_and_is_what_is_printed(page: Any) -> None:
    opened(page, "forces")
    assert not page.is_visible("#forces img")
    page.emulate_media(media="print")
    assert page.is_visible("#forces img")
    assert not page.is_visible("#forces canvas")
    page.emulate_media(media="screen")
    page.click("#forces .look")
    assert page.is_visible("#forces img")
    assert page.locator("#forces canvas").count() == 0


def test_a_closer_look_is_accessible(page: Any) -> None:
    from axe_playwright_python.sync_playwright import Axe

    for name in ("forces", "currents"):
        opened(page, name).press("+")
    violations = Axe().run(page).response["violations"]
    assert [(v["id"], v["nodes"][0]["html"][:200]) for v in violations] == []
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"


def test_without_scripts_the_pictures_stay(chromium: Any, report: Path) -> None:
    page = chromium.new_page(java_script_enabled=False)
    page.goto(report.as_uri())
    assert page.locator("img").count() == 3
    assert page.locator("button").count() == 0
    page.close()


ZOOM = """async (frames) => {
  const canvas = document.querySelector("#forces canvas");
  const times = [];
  for (let i = 0; i <= frames; i++) {
    const key = i % 24 < 12 ? "+" : "-";
    canvas.dispatchEvent(new KeyboardEvent("keydown", { key }));
    times.push(await new Promise(requestAnimationFrame));
  }
  return times;
}"""


def test_a_minute_zooms_at_the_rate_of_the_screen(page: Any) -> None:
    """Half of the frames come in time, even where other programs take the computer's time."""
    opened(page, "forces")
    times = np.array(page.evaluate(ZOOM, 120))
    print(f"frames a second: {1000 / np.diff(times).mean():.1f}")
    assert np.median(np.diff(times)) < 1.2 * FRAME

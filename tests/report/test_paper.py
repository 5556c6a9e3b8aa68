"""Figures for a paper: as wide as their file's name says, with letters of that size, as vectors."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pypdfium2
import pytest
from PIL import Image
from pypdf import PdfReader

from ur5lib.report.figures.charts import calibration_panels, residual_panels, scatter_panels
from ur5lib.report.figures.house_style import Drawing, save
from ur5lib.report.figures.traces import CURRENT_PANELS, WRENCH_PANELS, Traces, draw_traces

NAMES = ["forces", "currents", "residuals", "friction", "calibration"]


def drawing(name: str) -> Drawing:
    """A figure of one of several kinds, one with more vertices than the report keeps as lines."""
    time = np.linspace(0, 60, 20_000)
    waves = np.outer(np.sin(time), np.arange(1.0, 7.0))
    thin = waves[::40]
    series = {"force sensor": (waves, "measured"), "F̂ᵐᵃᵖ": (0.9 * waves, "third")}
    errors = {"F̂ᵐᵃᵖ": (0.1 * waves, "third")}
    shares = {"in contact": np.full((3, 3), 80.0), "free": np.full((3, 3), 90.0)}
    match name:
        case "forces":
            return draw_traces(Traces(time, series, errors, (waves - 1, waves + 1)), WRENCH_PANELS)
        case "residuals":
            return residual_panels(thin, {"q̇ [rad/s]": thin, "τ [Nm]": thin}, "A")
        case "friction":
            return scatter_panels(thin, thin, ("velocity of joint {} [rad/s]", "τ of {} [Nm]"))
        case "calibration":
            return calibration_panels([50, 80, 95], {"F̂ᵐᵃᵖ": shares}, ["Fx", "Fy", "Fz"])
    return draw_traces(Traces(time, {"a": (waves, "joint")}), CURRENT_PANELS)


@pytest.mark.parametrize(
    ("name", "width", "size"),
    [*((name, 88, 6.5) for name in NAMES), ("calibration", 88, 8), ("currents", 180, 9)],
)
def test_figures_have_the_width_and_the_letters_of_their_name(
    name: str, width: float, size: float, tmp_path: Path
) -> None:
    path = tmp_path / f"a_{width}mm_{size:g}pt.pdf"
    save(drawing(name), path)
    assert not path.with_suffix(".csv").exists()
    (page,) = PdfReader(path).pages
    assert float(page.mediabox.width) / 72 * 25.4 == pytest.approx(width, abs=0.1)
    assert len(page.images) == 0
    text = pypdfium2.PdfDocument(path)[0].get_textpage()
    boxes = np.array([text.get_rect(i) for i in range(text.count_rects())])
    assert boxes.min() >= 0, "no text is cut"
    assert (boxes.max(axis=0)[2:] <= page.mediabox.upper_right).all()
    fonts = [font.get_object() for font in page["/Resources"]["/Font"].values()]
    assert fonts
    for font in fonts:
        described = font["/DescendantFonts"][0].get_object()["/FontDescriptor"].get_object()
        assert "/FontFile2" in described, "TrueType, embedded"
    sizes: dict[str, float] = {}
    page.extract_text(visitor_text=lambda text, *told: sizes.update({text.strip(): told[-1]}))
    of_letters = {round(found / size, 2) for text, found in sizes.items() if text}
    assert 1 in of_letters
    assert of_letters <= {1, 0.7}  # of indices


def test_the_same_data_are_the_same_file(tmp_path: Path) -> None:
    first, again = (tmp_path / f"{copy}_88mm_8pt.pdf" for copy in "ab")
    for path in (first, again):
        save(drawing("calibration"), path)
    assert first.read_bytes() == again.read_bytes()


def test_a_png_has_the_pixels_of_print_and_an_svg_its_width(tmp_path: Path) -> None:
    for ending in ("png", "svg"):
        save(drawing("currents"), tmp_path / f"a_88mm_8pt.{ending}")
    assert Image.open(tmp_path / "a_88mm_8pt.png").width == pytest.approx(88 / 25.4 * 600, abs=1)
    root = ElementTree.parse(tmp_path / "a_88mm_8pt.svg").getroot()
    assert float(root.get("width", "").removesuffix("pt")) == pytest.approx(88 / 25.4 * 72, abs=0.1)

"""Figures for a paper: as wide as a column, with their fonts."""

from pathlib import Path

import numpy as np
import pypdfium2
import pytest
from pypdf import PdfReader

from ur5lib.report.figures.charts import calibration_panels, residual_panels, scatter_panels
from ur5lib.report.figures.house_style import Drawing, save
from ur5lib.report.figures.traces import CURRENT_PANELS, WRENCH_PANELS, Traces, draw_traces

COLUMN = 88.0  # mm
SMALLEST = 6.0  # points


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


@pytest.mark.parametrize("name", ["forces", "currents", "residuals", "friction", "calibration"])
def test_figures_fit_a_column_with_their_fonts(name: str, tmp_path: Path) -> None:
    for copy in ("a", "b"):
        save(drawing(name), tmp_path / f"{copy}.pdf")
    assert (tmp_path / "a.pdf").read_bytes() == (tmp_path / "b.pdf").read_bytes()
    assert not (tmp_path / "a.csv").exists()
    (page,) = PdfReader(tmp_path / "a.pdf").pages
    assert float(page.mediabox.width) / 72 * 25.4 == pytest.approx(COLUMN, abs=0.1)
    assert len(page.images) == 0
    text = pypdfium2.PdfDocument(tmp_path / "a.pdf")[0].get_textpage()
    boxes = np.array([text.get_rect(i) for i in range(text.count_rects())])
    assert boxes.min() >= 0, "no text is cut"
    assert (boxes.max(axis=0)[2:] <= page.mediabox.upper_right).all()
    fonts = [font.get_object() for font in page["/Resources"]["/Font"].values()]
    assert fonts
    for font in fonts:
        described = font["/DescendantFonts"][0].get_object()["/FontDescriptor"].get_object()
        assert "/FontFile2" in described, "TrueType, embedded"
    sizes: list[float] = []
    page.extract_text(visitor_text=lambda *told: sizes.append(told[-1]))
    assert min(size for size in sizes if size) >= 0.7 * SMALLEST  # indices are smaller

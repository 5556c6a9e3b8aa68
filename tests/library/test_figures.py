"""Figures: the same file for the same data, every peak, every gap, units on every axis."""

from base64 import b64decode
from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from ur5lib.report import house_style
from ur5lib.report.friction_figures import MovingSamples, friction_figures
from ur5lib.report.house_style import EMBEDDED, JOINTS, Drawing, save
from ur5lib.report.traces import TORQUE, WRENCH, Traces, decimate, draw_traces

LONG = 20_000


def drawing(count: int = 50, panels: list = WRENCH, **more: object) -> Drawing:
    time = np.linspace(0, 1, count)
    measured = np.outer(np.cos(40 * time), np.arange(1.0, 7.0))
    series = {"sensor": (measured, "measured"), "estimate": (0.9 * measured, "joint")}
    return draw_traces(Traces(time, series, **more), panels)  # type: ignore[arg-type]


def test_the_same_figure_is_the_same_file(tmp_path: Path) -> None:
    for name in ("a", "b"):
        save(drawing(LONG), tmp_path / f"{name}.svg")
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def images(svg: bytes) -> list[np.ndarray]:
    """The images of an SVG over white, (H, W, 4)."""
    found = [Image.open(BytesIO(b64decode(data))) for data in EMBEDDED.findall(svg)]
    return [
        np.asarray(Image.alpha_composite(Image.new("RGBA", one.size, "white"), one.convert("RGBA")))
        for one in found
    ]


def test_an_image_with_a_palette_looks_the_same_and_is_half_as_large(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save(drawing(LONG), tmp_path / "palette.svg")
    monkeypatch.setattr(house_style, "_with_palette", lambda image: image[0])
    save(drawing(LONG), tmp_path / "full.svg")
    palette, full = ((tmp_path / f"{name}.svg").read_bytes() for name in ("palette", "full"))
    found, expected = (
        np.concatenate([image.ravel() for image in images(svg)]).astype(float)
        for svg in (palette, full)
    )
    error = np.abs(found - expected)  # of 255
    assert error.mean() < 1
    assert np.quantile(error, 0.999) < 32
    sizes = [sum(map(len, EMBEDDED.findall(svg))) for svg in (palette, full)]
    assert 0 < sizes[0] < sizes[1] / 2


def test_what_is_drawn_lies_beside_the_figure(tmp_path: Path) -> None:
    save(drawing(), tmp_path / "figure.svg")
    data = pd.read_csv(tmp_path / "figure.csv")
    assert [*data.columns[:2]] == ["time [s]", "sensor, Fx [N]"]
    expected = 0.9 * data["sensor, nz [Nm]"].to_numpy()
    assert data["estimate, nz [Nm]"].to_numpy() == pytest.approx(expected, rel=1e-4)


def test_nothing_recorded_is_told_and_has_no_numbers(tmp_path: Path) -> None:
    save(draw_traces(Traces(np.arange(3.0), {}), TORQUE), tmp_path / "empty.svg")
    assert "not recorded" in (tmp_path / "empty.svg").read_text()
    assert (tmp_path / "empty.csv").read_text().strip() == ""


def test_forces_stand_left_and_moments_right() -> None:
    axes = drawing().figure.axes
    assert [axis.get_ylabel() for axis in axes] == [
        "$F_x$ [N]", "$n_x$ [Nm]", "$F_y$ [N]", "$n_y$ [Nm]", "$F_z$ [N]", "$n_z$ [Nm]",
    ]  # fmt: skip
    scale = [axis.lines[0].get_ydata()[0] for axis in axes]
    assert scale == [1, 4, 2, 5, 3, 6]


def test_joints_have_the_same_colours_everywhere() -> None:
    axes = drawing(panels=TORQUE).figure.axes
    assert [axis.lines[1].get_color() for axis in axes] == [*JOINTS[:6]]


def test_known_torque_constants_are_drawn_beside_the_fitted_ones() -> None:
    """Each line's slope is the current that a torque needs, 1/k [A/Nm]."""
    fitted, known = np.arange(5.0, 11.0), np.full(6, 10.0)
    torque = np.outer(np.linspace(-1, 1, 50), np.arange(1.0, 7.0))
    samples = MovingSamples(torque, torque, torque, torque, torque / known, torque / fitted)
    figures = friction_figures(samples, fitted, known)
    for name in ("current_torque", "current_torque_friction"):
        for joint, axis in enumerate(figures[name].figure.axes):
            _, *lines = axis.lines
            slopes = [np.polyfit(line.get_xdata(), line.get_ydata(), 1)[0] for line in lines]
            np.testing.assert_allclose(slopes, [1 / fitted[joint], 1 / known[joint]])


@pytest.mark.parametrize(("sensed", "unit"), [(False, "[A]"), (True, "[Nm]")])
def test_what_a_joint_measures_has_its_unit(sensed: bool, unit: str) -> None:
    samples = MovingSamples(*np.random.default_rng(0).normal(size=(6, 50, 6)))
    figures = friction_figures(samples, np.ones(6), np.ones(6), sensed)
    assert figures["current_torque"].figure.axes[0].get_ylabel().endswith(unit)
    assert figures["residuals"].figure.axes[0].get_ylabel().endswith(unit)


def test_errors_stand_under_values() -> None:
    time = np.arange(50.0)
    wrong = {"estimate": (np.full((50, 6), 0.5), "joint")}
    series = {"measured": (np.ones((50, 6)), "measured")}
    axes = draw_traces(Traces(time, series, wrong), TORQUE).figure.axes
    assert len(axes) == 12
    places = {axis.get_ylabel(): axis.get_position() for axis in axes}
    errors = [axis.get_position() for axis in axes if "Delta" in axis.get_ylabel()]
    assert len(errors) == 6
    above = places[r"$\tau_1$ [Nm]"]
    assert any(below.x0 == above.x0 and below.y1 < above.y0 for below in errors)


def test_gaps_and_singular_stretches_are_shaded() -> None:
    time = np.array([0.0, 1.0, 2.0, np.nan, 5.0, 6.0, 7.0])
    series = {"a": (np.ones((7, 6)), "measured")}
    hidden = np.array([0, 1, 1, 1, 0, 0, 1]) == 1
    figure = draw_traces(Traces(time, series, hidden=hidden), WRENCH).figure
    spans = sorted((span.get_x(), span.get_width()) for span in figure.axes[0].patches)
    assert spans == [(1, 1), (2, 3), (7, 0)]
    assert {"gap", "near a singularity"} <= {t.get_text() for t in figure.legends[0].get_texts()}


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.integers(3, 4000), st.lists(st.integers(1, 3999), max_size=3))
def test_decimation_keeps_every_peak_and_gap(seed: int, count: int, cuts: list[int]) -> None:
    chance = np.random.default_rng(seed)
    time, values = np.arange(float(count)), chance.normal(size=(count, 2))
    for cut in {cut for cut in cuts if cut < count - 1}:
        time[cut], values[cut] = np.nan, np.nan
    thin_time, thin = decimate(time, values, points=100)
    assert len(thin) <= max(100, 2) + 4 * (len(cuts) + 1) or len(thin) == count
    assert np.nanmax(thin, axis=0) == pytest.approx(np.nanmax(values, axis=0))
    assert np.nanmin(thin, axis=0) == pytest.approx(np.nanmin(values, axis=0))
    assert np.isnan(thin_time).sum() == np.isnan(time).sum()
    known = thin_time[np.isfinite(thin_time)]
    assert (np.diff(known) >= 0).all()


def test_decimation_of_few_samples_changes_nothing() -> None:
    time, values = np.arange(10.0), np.arange(20.0).reshape(10, 2)
    assert decimate(time, values)[1] is values

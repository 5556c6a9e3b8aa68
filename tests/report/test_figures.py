"""Figures: the same file for the same data, every peak, every gap, units; and those of recordings
and arms.
"""

from base64 import b64decode
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.patches import Rectangle
from PIL import Image

from tests.current_study import noisy, prior, smooth
from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.identification.current_regression import fit_currents
from ur5lib.identification.currents import band, parameters, predict
from ur5lib.identification.steady_friction import friction_curve, mean_load
from ur5lib.records.currents import Currents
from ur5lib.records.friction import Friction
from ur5lib.records.signals import Signals, is_led
from ur5lib.report.figures import house_style
from ur5lib.report.figures.arm_figures import (
    UPRIGHT_POSTURE,
    MassModel,
    cylinder_outline,
    ellipsoid_outline,
    frame_panels,
    mass_panels,
    placed,
)
from ur5lib.report.figures.friction_figures import (
    MovingSamples,
    band_over,
    correlation_figure,
    current_figures,
    friction_figure,
)
from ur5lib.report.figures.house_style import EMBEDDED_IMAGE, JOINT_COLOURS, Drawing, save
from ur5lib.report.figures.recording_figures import packet_figure
from ur5lib.report.figures.traces import TORQUE_PANELS, WRENCH_PANELS, Traces, decimate, draw_traces
from ur5lib.robots.description import Cylinder, Robot
from ur5lib.robots.statics import link_frames
from ur5lib.steps.draw_filters import FILTERED, draw_filters
from ur5lib.timeseries.lowpass import Butterworth

LONG = 20_000


def drawing(count: int = 50, panels: list = WRENCH_PANELS, **more: object) -> Drawing:
    time = np.linspace(0, 1, count)
    measured = np.outer(np.cos(40 * time), np.arange(1.0, 7.0))
    series = {"sensor": (measured, "measured"), "estimate": (0.9 * measured, "joint")}
    return draw_traces(Traces(time, series, **more), panels)


def test_the_same_figure_is_the_same_file(tmp_path: Path) -> None:
    for name in ("a", "b"):
        save(drawing(LONG), tmp_path / f"{name}.svg")
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def images(svg: bytes) -> list[np.ndarray]:
    """The images of an SVG over white, (H, W, 4)."""
    found = [Image.open(BytesIO(b64decode(data))) for data in EMBEDDED_IMAGE.findall(svg)]
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
    sizes = [sum(map(len, EMBEDDED_IMAGE.findall(svg))) for svg in (palette, full)]
    assert 0 < sizes[0] < sizes[1] / 2


def test_what_is_drawn_lies_beside_the_figure(tmp_path: Path) -> None:
    save(drawing(), tmp_path / "figure.svg")
    data = pd.read_csv(tmp_path / "figure.csv")
    assert [*data.columns[:2]] == ["time [s]", "sensor, Fx [N]"]
    expected = 0.9 * data["sensor, nz [Nm]"].to_numpy()
    assert data["estimate, nz [Nm]"].to_numpy() == pytest.approx(expected, rel=1e-4)


def test_nothing_recorded_is_told_and_has_no_numbers(tmp_path: Path) -> None:
    save(draw_traces(Traces(np.arange(3.0), {}), TORQUE_PANELS), tmp_path / "empty.svg")
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
    axes = drawing(panels=TORQUE_PANELS).figure.axes
    assert [axis.lines[1].get_color() for axis in axes] == [*JOINT_COLOURS[:6]]


def test_each_filter_of_the_study_is_drawn() -> None:
    _, *names = draw_filters(dict.fromkeys(FILTERED, Butterworth(4, 10.0)))["filters"].data
    assert len(names) == len(FILTERED)
    assert all("order 4, 10 Hz, both ways" in name for name in names)


def test_known_torque_constants_are_drawn_beside_the_fitted_ones() -> None:
    """Each line's slope is the current that a torque needs, 1/k [A/Nm]."""
    fitted, known = np.arange(5.0, 11.0), np.full(6, 10.0)
    torque = np.outer(np.linspace(-1, 1, 50), np.arange(1.0, 7.0))
    efforts = torque / known, torque / fitted, 0 * torque
    samples = MovingSamples(torque, torque, torque, torque, *efforts, *3 * [torque])
    figures = current_figures(samples, fitted, known)
    for name in ("current_torque", "current_torque_friction"):
        for joint, axis in enumerate(figures[name].figure.axes):
            _, *lines = axis.lines
            slopes = [np.polyfit(line.get_xdata(), line.get_ydata(), 1)[0] for line in lines]
            np.testing.assert_allclose(slopes, [1 / fitted[joint], 1 / known[joint]])


@pytest.fixture(scope="module")
def noisy_friction() -> tuple[Friction, MovingSamples, float]:
    """The fit to made-up recordings, their samples, and the share of these within the band that is
    stated for each.
    """
    records = noisy(range(6))
    fit = fit_currents(records, smooth, prior())
    load = mean_load(records, smooth, fit.joints[0].terms)
    friction, parts, inside = Friction(fit=fit, parameters=parameters(fit), load=load), [], []
    for record in records:
        stated = predict(fit, record), band(fit, record, smooth)
        own = Currents(
            time=record.period * np.arange(len(record.q)),
            segment=record.segment,
            predicted_current=stated[0],
            current_band=stated[1],
        )
        parts.append(MovingSamples.from_record(record, friction, own, smooth))
        moves = np.isfinite(parts[-1].qd)
        every = round(0.1 / record.period)
        error = smooth(record.current - stated[0], record)
        inside.append((np.abs(error) <= stated[1])[::every][moves])
    share = float(np.concatenate(inside).mean())
    return friction, MovingSamples.joined(parts, 6), share


def drawn_friction(numbers: pd.DataFrame, joint: int) -> np.ndarray:
    """Velocity, friction, fitted friction and half of the band of a joint's dots."""
    rows = numbers.filter(regex=f"joint {joint} ").to_numpy()[:, :4]
    return rows[np.isfinite(rows).all(axis=1)].T


def test_the_curve_of_friction_is_that_of_the_table(
    noisy_friction: tuple[Friction, MovingSamples, float],
) -> None:
    friction, samples, _ = noisy_friction
    numbers = friction_figure(samples, friction.fit.joints, friction.load).data
    for joint in range(1, 7):
        table = {row.name: row.value for row in friction.parameters if row.joint == joint}
        qd, _, fitted, _ = drawn_friction(numbers, joint)
        load = np.nanmean(np.abs(samples.torque[:, joint - 1]))
        dry = table["coulomb"] + table["load"] * load
        expected = np.sign(qd) * dry + table["viscous"] * qd
        if "velocity_root" in table:
            column = np.sqrt(np.abs(qd)) * np.sign(qd) - 4 / 15 * np.sign(qd) - 4 / 5 * qd
            expected += table["velocity_root"] * column
        np.testing.assert_allclose(fitted, expected)


def test_as_much_friction_is_drawn_within_the_band_as_the_band_holds(
    noisy_friction: tuple[Friction, MovingSamples, float],
) -> None:
    friction, samples, share = noisy_friction
    numbers = friction_figure(samples, friction.fit.joints, friction.load).data
    dots = [drawn_friction(numbers, joint) for joint in range(1, 7)]
    inside = [np.abs(own - fitted) <= half for _, own, fitted, half in dots]
    assert 0.5 < share < 1
    assert np.concatenate(inside).mean() == pytest.approx(share, abs=0.01)
    assert (samples.resting[1:] > 0).all()
    at_rest = numbers.filter(like="at rest").iloc[0].to_numpy()
    np.testing.assert_allclose(at_rest, np.nanmean(samples.resting, axis=0))


def test_a_band_over_velocity_is_the_mean_of_its_neighbours_in_the_same_direction() -> None:
    qd = np.array([np.nan, *np.linspace(-1, -0.1, 300), *np.linspace(0.1, 1, 300)])
    half = np.where(qd < 0, 2.0, 1 + np.abs(qd))
    found = band_over(qd, half, np.array([-0.5, 0.3, 0.7, np.nan]))
    np.testing.assert_allclose(found, [2.0, 1.3, 1.7, np.nan], rtol=0.01)


def test_parameters_that_make_up_for_each_other_correlate(
    noisy_friction: tuple[Friction, MovingSamples, float],
) -> None:
    model = noisy_friction[0].fit.joints[0]
    draws = 1 + np.random.default_rng(0).normal(scale=0.01, size=(200, len(model.names())))
    draws[:, 0], draws[:, 1], draws[:, 3] = 0.1, 0.0, -draws[:, 2]
    unmoved = replace(model, estimate=replace(model.estimate, replicates=0 * draws + 1))
    draws[:, :2] += 1e-4 * draws[::-1, 2:4]
    own = replace(model, estimate=replace(model.estimate, replicates=draws))
    drawn = correlation_figure([own, unmoved]).data.set_index("parameter")
    assert {*drawn["joint"]} == {1}
    assert drawn.loc["coulomb", "viscous"] == pytest.approx(-1, abs=0.02)
    assert drawn.loc["coulomb", "coulomb"] == pytest.approx(1)


def test_a_spring_is_no_friction(noisy_friction: tuple[Friction, MovingSamples, float]) -> None:
    """A counterbalance leaves the curve as it is."""
    model, qd = noisy_friction[0].fit.joints[0], np.array([-0.5, 0.5])
    sprung = np.append(model.estimate.coefficients, [9.0, 9.0])
    estimate = replace(model.estimate, coefficients=sprung)
    other = replace(model, terms=(*model.terms, "balance"), estimate=estimate)
    np.testing.assert_allclose(friction_curve(other, qd, 5.0), friction_curve(model, qd, 5.0))


@pytest.mark.filterwarnings("error")
def test_a_joint_that_rests_has_an_empty_panel(
    noisy_friction: tuple[Friction, MovingSamples, float],
) -> None:
    values = np.abs(np.random.default_rng(0).normal(size=(10, 50, 6)))
    values[..., 4] = np.nan
    samples = MovingSamples(*values)
    drawings = current_figures(samples, np.ones(6), np.ones(6))
    drawings["friction"] = friction_figure(samples, noisy_friction[0].fit.joints, np.ones(6))
    for drawing in drawings.values():
        assert drawing.data.filter(regex="(τ|i)_5 |joint 5").isna().all(axis=None)


@pytest.mark.parametrize(("effort", "unit"), [(CURRENT, "[A]"), (TORQUE, "[Nm]")])
def test_what_a_joint_measures_has_its_unit(effort: Effort, unit: str) -> None:
    samples = MovingSamples(*np.random.default_rng(0).normal(size=(10, 50, 6)))
    figures = current_figures(samples, np.ones(6), np.ones(6), effort)
    assert figures["current_torque"].figure.axes[0].get_ylabel().endswith(unit)
    assert figures["residuals"].figure.axes[0].get_ylabel().endswith(unit)


@pytest.mark.parametrize("count", [1, 3, 4, 6])
def test_a_legend_lies_within_the_figure_above_the_panels(count: int) -> None:
    time = np.linspace(0, 1, 50)
    names = [f"Model {k} at the target motion, without rotors" for k in range(count)]
    lines = {name: (np.ones((50, 6)), "first") for name in names}
    figure = draw_traces(Traces(time, lines, errors=lines), TORQUE_PANELS).figure
    figure.draw_without_rendering()
    (legend,) = figure.legends
    shown = legend.get_window_extent()
    assert figure.bbox.x0 <= shown.x0 < shown.x1 <= figure.bbox.x1
    assert all(shown.y0 >= axes.get_window_extent().y1 for axes in figure.axes)


def test_errors_stand_under_values() -> None:
    time = np.arange(50.0)
    wrong = {"estimate": (np.full((50, 6), 0.5), "joint")}
    series = {"measured": (np.ones((50, 6)), "measured")}
    axes = draw_traces(Traces(time, series, wrong), TORQUE_PANELS).figure.axes
    assert len(axes) == 12
    places = {axis.get_ylabel(): axis.get_position() for axis in axes}
    errors = [axis.get_position() for axis in axes if "Delta" in axis.get_ylabel()]
    assert len(errors) == 6
    above = places[r"$\tau_1$ [Nm]"]
    assert any(below.x0 == above.x0 and below.y1 < above.y0 for below in errors)


def test_round_times_are_marked_in_every_panel() -> None:
    """Where they have no labels, by a path at the ticks of the panels that have some."""
    axes = drawing().figure.axes
    ticks = axes[-1].get_xticks()
    assert len(ticks) > 3
    for axis in axes[:-2]:
        (lines,) = axis.patches
        marked = lines.get_transform().transform(lines.get_path().vertices)
        ends = axis.transData.transform([(time, 0) for time in ticks])[:, 0]
        assert marked[:, 0] == pytest.approx(np.repeat(ends, 2))
        assert [*np.ptp(marked[:, 1].reshape(-1, 2), axis=1)] == pytest.approx(
            [axis.bbox.height] * len(ticks)
        )


def test_gaps_and_singular_stretches_are_shaded() -> None:
    time = np.array([0.0, 1.0, 2.0, np.nan, 5.0, 6.0, 7.0])
    series = {"a": (np.ones((7, 6)), "measured")}
    hidden = np.array([0, 1, 1, 1, 0, 0, 1]) == 1
    figure = draw_traces(Traces(time, series, hidden=hidden), WRENCH_PANELS).figure
    patches = figure.axes[0].patches
    spans = sorted((p.get_x(), p.get_width()) for p in patches if isinstance(p, Rectangle))
    assert spans == [(1, 1), (2, 3), (7, 0)]
    assert {"gap", "near a singularity"} <= {t.get_text() for t in figure.legends[0].get_texts()}


@settings(max_examples=60)
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


@pytest.mark.parametrize("first", [0, 7, 18])
def test_decimation_keeps_the_order_of_lowest_and_highest_values(first: int) -> None:
    """Of one sample each in every bucket of twenty, one after the other."""
    time = np.arange(1000.0)
    swing = (time % 20 == first) * 1.0 - (time % 20 == first + 1)
    _, thin = decimate(time, np.stack([swing, -swing], axis=1), points=100)
    np.testing.assert_array_equal(thin[:, 0], np.tile([1.0, -1.0], 50))
    np.testing.assert_array_equal(thin[:, 1], np.tile([-1.0, 1.0], 50))


def test_decimation_of_few_samples_changes_nothing() -> None:
    time, values = np.arange(10.0), np.arange(20.0).reshape(10, 2)
    assert decimate(time, values)[1] is values


# Of recordings

COUNT, PERIOD = 200, 0.008


def signals(lost: np.ndarray | None = None) -> Signals:
    time = PERIOD * np.arange(COUNT)
    q = np.outer(np.sin(time), np.arange(1.0, 7.0))
    return Signals(
        time=time,
        segment=np.zeros(COUNT, dtype=int),
        interpolated=np.zeros(COUNT, dtype=bool) if lost is None else lost,
        actual_q=q,
        target_q=q + 0.25,
        target_moment=10 * q,
    )


def test_lost_frames_lengthen_the_step_to_the_next_received_one() -> None:
    lost = np.isin(np.arange(COUNT), [28, 29, 31, 32])
    data = packet_figure(signals(lost)).data
    late = data[data["step to this frame [ms]"] > 8.5]
    assert late["time [s]"].tolist() == pytest.approx([0.240, 0.264])
    assert late["step to this frame [ms]"].tolist() == pytest.approx([24, 24])
    assert len(data) == COUNT - 1 - lost.sum()


def test_speeds_that_were_not_recorded_are_the_slopes_of_positions() -> None:
    """The last of six joints swings by six times the sine."""
    lost = np.isin(np.arange(COUNT), [28, 29])
    [line] = packet_figure(signals(lost)).figure.axes[1].lines
    time, speed = line.get_data()
    np.testing.assert_allclose(speed, 6 * np.abs(np.cos(time)), atol=0.05)


def test_a_recording_without_lost_frames_has_no_figure_of_them() -> None:
    assert packet_figure(signals()).data.empty


# Of arms

HEIGHT = 1.04  # m, of the UR5 in position 2 of Figure 4.1


@pytest.fixture(scope="module")
def models(ur5: Robot) -> dict[str, MassModel]:
    rotation, origin = (part[0] for part in link_frames(ur5, np.array([UPRIGHT_POSTURE])))
    return {name: placed(ur5, name, rotation, origin) for name in ("A", "B", "C")}


def all_outlines(model: MassModel) -> np.ndarray:
    return np.concatenate([body for link in model.outlines for body in link])


def test_a_ball_is_drawn_with_its_radius() -> None:
    outline = ellipsoid_outline(2.0, 0.4 * 2.0 * 0.3**2 * np.eye(3), np.array([9.0, 1.0, 2.0]))
    assert np.hypot(*(outline - [1.0, 2.0]).T) == pytest.approx(0.3)


@pytest.mark.parametrize(("axis", "seen"), [("x", [0.4, 0.4]), ("y", [1, 0.4]), ("z", [0.4, 1])])
def test_a_cylinder_is_drawn_with_its_height_and_diameter(axis: str, seen: list[float]) -> None:
    part = Cylinder(axis=axis, mass=1, height=1, radius=0.2, offset=(0, 0.1, 0))
    outline = cylinder_outline(part, np.array([0.0, 1.0, 2.0]), np.eye(3))
    assert np.ptp(outline, axis=0) == pytest.approx(seen)
    assert (outline.min(axis=0) + outline.max(axis=0)) / 2 == pytest.approx([1.1, 2.0])


@pytest.mark.parametrize("name", ["A", "B", "C"])
def test_the_cylinders_are_as_high_as_the_arm(models: dict[str, MassModel], name: str) -> None:
    assert all_outlines(models[name]).max(axis=0)[1] == pytest.approx(HEIGHT, abs=0.005)


def test_every_cylinder_lies_inside_the_frame(ur5: Robot, models: dict[str, MassModel]) -> None:
    origin = link_frames(ur5, np.array([UPRIGHT_POSTURE]))[1][0]
    counts = {name: sum(map(len, model.outlines)) for name, model in models.items()}
    assert counts == {"A": 6, "B": 6, "C": 17}
    assert "ellipses" not in mass_panels(origin, models).data
    for axis, model in zip(mass_panels(origin, models).figure.axes, models.values(), strict=True):
        (left, right), (low, high) = axis.get_xlim(), axis.get_ylim()
        outline = all_outlines(model)
        assert (outline > [left, low]).all()
        assert (outline < [right, high]).all()


def test_an_undetermined_link_does_not_shrink_the_arm(models: dict[str, MassModel]) -> None:
    astray = models["C"]._replace(outlines=[[50 + body for body in models["C"].outlines[0]]] * 6)
    low, high = (
        mass_panels(np.zeros((7, 3)), {"C": models["C"], "astray": astray})
        .figure.axes[0]
        .get_ylim()
    )
    assert high - low < 1.5


def test_the_frames_are_those_of_the_arm(ur5: Robot) -> None:
    rotation, origin = (part[0] for part in link_frames(ur5, np.array([UPRIGHT_POSTURE])))
    data = frame_panels(rotation, origin, ur5.denavit_hartenberg).data
    assert data[["x [m]", "y [m]", "z [m]"]].to_numpy() == pytest.approx(origin)
    assert data.filter(like="z axis").to_numpy() == pytest.approx(rotation[:, :, 2])
    assert data["d [m]"][1:].tolist() == [0.08916, 0, 0, 0.10915, 0.09465, 0.0823]  # Table 5.2


def test_targets_of_an_arm_that_a_hand_leads_judge_no_link_model() -> None:
    """The torque of a target that rests is not that of the motion."""
    own = signals()
    assert not is_led(own)
    assert is_led(replace(own, target_q=np.zeros_like(own.actual_q)))

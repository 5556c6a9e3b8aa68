"""Whether *Replay* draws an arm where its kinematics and its forces say."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from tests.artefacts.documents import LOADED_MS, browser
from ur5lib.finished import StudyFiles
from ur5lib.force.estimators import NEW
from ur5lib.records.forces import Forces, SensorWrenches
from ur5lib.records.signals import Signals
from ur5lib.report.figures.scene import shown_rows, upright
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array

VIEWS = [(-1.1, 0.35), (0.4, -0.2), (2.0, 1.5)]  # turn and tilt [rad]
TWO_SIGMA = np.sqrt(-2 * np.log(0.05))  # of 95 % in a plane
LEVELS = 255  # of packed forces, in their range
DRAWN = """([recording, time, [turn, tilt]]) => {
  const stretch = stretches.get(recording), [look] = stretch.looks, { arm } = look;
  Object.assign(stretch.view, { turn, tilt });
  stretch.show(stretch.first, stretch.last);
  stretch.point(time);
  look.draw();
  const { origins, force, sensed, perNewton } = arm.scene.at(time);
  const points = origins.map((origin) => arm.place(origin));
  const tip = arm.tip(force), pen = arm.canvas.getContext("2d");
  const { data, width } = pen.getImageData(0, 0, arm.canvas.width, arm.canvas.height);
  const start = points.at(-1), sharp = window.devicePixelRatio;
  const colours = Array.from({ length: 40 }, (_, i) => {
    const place = start.map((from, axis) => from + (0.2 + i / 100) * (tip[axis] - from));
    const [x, y] = place.map((one) => Math.floor(sharp * one));
    return [...data.slice(4 * (y * width + x), 4 * (y * width + x) + 3)];
  });
  return { points, tip, sensed: sensed && arm.tip(sensed), ellipse: arm.ellipse(),
    scale: arm.scale, perNewton,
    size: [arm.canvas.clientWidth, arm.canvas.clientHeight],
    colours,
    text: arm.element.querySelector(".readout").innerText };
}"""


def check_arm(results: Path, recording: str) -> None:
    """Where the tables of a recording say, at times of a small, a larger and a large force."""
    study = StudyFiles(results)
    signals, forces = study.record(Signals, recording), study.record(Forces, recording)
    sensor = SensorWrenches.read(results / "recordings" / recording / "sensor.parquet")
    entry = study.recording(recording)
    robot = study.arm(entry.robot).mounted(entry.gravity)
    lead = next(name for name in NEW if name in forces.wrench)
    force, std, sensed = forces.wrench[lead], forces.std[lead], sensor.wrench.get("compensated")
    rows = shown_rows(signals.segment, signals.period)
    size = np.linalg.norm(force[rows, :3], axis=1)
    known = rows[np.argsort(size)][: np.isfinite(size).sum()]
    with browser() as chromium:
        page = chromium.new_page()
        drawn = (results / name for name in ("report.html", "details.html"))
        report = next(one for one in drawn if f'data-recording="{recording}"' in one.read_text())
        page.goto(report.as_uri(), timeout=LOADED_MS)
        closed = f"figure[data-recording='{recording}'] .look[aria-expanded=false]"
        if not page.query_selector(f"figure[data-recording='{recording}'][data-open]"):
            page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
            page.locator(closed).first.click()
        page.wait_for_selector(".arm canvas")
        for share, view in zip((0.5, 0.9, 0.98), VIEWS, strict=True):
            row = known[int(share * len(known))]
            felt = None if sensed is None else sensed[row, :3]
            at = signals.time[row], signals.actual_q[row], force[row, :3], std[row, :3], felt
            packed = np.nanmax(std[rows, :3]) / LEVELS
            check_drawn(page, recording, robot, at, view, packed)


def check_drawn(
    page: Any,
    recording: str,
    robot: Robot,
    at: tuple[float, Array, Array, Array, Array | None],
    view: tuple[float, float],
    packed: float = 0.0,
) -> None:
    """At a time: positions (n,) [rad], force and its deviation (3,) [N], and the sensor's if any.

    robot: under the recording's gravity; packed: step of the deviations [N]. Positions are packed
    to 0.001 rad, forces to 1/255 of their range.
    """
    time, q, force, std, sensed = at
    drawn = page.evaluate(DRAWN, [recording, time, view])
    projection, up = projected(view), upright(robot.gravity)
    _, origins = link_frames(robot, q[None])
    points, scale = np.array(drawn["points"]), drawn["scale"]
    expected = scale * origins[0] @ up.T @ projection.T
    np.testing.assert_allclose(points - points[0], expected - expected[0], atol=1.0)
    for shown in (points, np.array(drawn["tip"]) + extents(drawn["ellipse"])):
        assert (shown > 0).all()
        assert (shown < drawn["size"]).all()
    per_newton = scale * drawn["perNewton"]
    for tip, known in (("tip", force), ("sensed", sensed)):
        if known is not None:
            arrow = per_newton * projection @ up @ known
            np.testing.assert_allclose(np.array(drawn[tip]) - points[-1], arrow, atol=1.5)
    half = per_newton * TWO_SIGMA * projection @ up @ np.diag(std)
    check_ellipse(drawn["ellipse"], half, per_newton * TWO_SIGMA * packed)
    if np.hypot(*(np.array(drawn["tip"]) - points[-1])) > 40:
        assert [0, 158, 115] in drawn["colours"]  # the sensor's arrow is above
    if not force.any():  # its band would be taken for what a push must exceed
        said = r"Force x, y, z by [^:]*: no contact found; one of up to [^;]*\sN could be hidden"
        assert re.search(said, drawn["text"])
        return
    told = re.search(r"Force x, y, z by .*?: (.*?), 95 % ± (.*?)\sN", drawn["text"])
    assert told is not None
    for text, known in zip(told.groups(), (force, 1.96 * std), strict=True):
        numbers = [float(number.replace("−", "-")) for number in text.split(", ")]
        np.testing.assert_allclose(numbers, known, atol=0.06 + 0.01 * np.abs(known).max())


def projected(view: tuple[float, float]) -> Array:
    """The picture's axes (2, 3), x to the right and y downwards, of axes whose z points up."""
    turn, tilt = view
    c, s = np.cos(turn), np.sin(turn)
    return np.array([[-s, c, 0], [np.sin(tilt) * c, np.sin(tilt) * s, -np.cos(tilt)]])


def extents(ellipse: dict[str, float]) -> Array:
    """The corners (2, 2) of the box around an ellipse, from its middle [pixels]."""
    c, s = np.cos(ellipse["angle"]), np.sin(ellipse["angle"])
    half = np.hypot(np.array([c, s]) * ellipse["across"], np.array([s, c]) * ellipse["along"])
    return np.array([-half, half])


def check_ellipse(drawn: dict[str, float], half: Array, step: float) -> None:
    """Its matrix is half halfᵀ; half: (2, 3) [pixels], packed in steps [pixels]."""
    c, s = np.cos(drawn["angle"]), np.sin(drawn["angle"])
    turn = np.array([[c, -s], [s, c]])
    matrix = turn @ np.diag([drawn["across"] ** 2, drawn["along"] ** 2]) @ turn.T
    expected = half @ half.T
    largest = np.abs(expected).max()
    np.testing.assert_allclose(matrix, expected, atol=0.06 * largest + step * np.sqrt(largest))

// A figure over time, drawn by uPlot: a plot for each panel, with the values at the time pointed at.
"use strict";

const HEIGHT = 170, LOWEST = 96, TITLE = 24; // pixels of a plot, with its times, and of its title
const ESTIMATE = "#009e73"; // of the leading estimate
// The band of the leading estimate where it finds a contact, and where it finds none (shut), up to the former.
const BAND = { label: "95 % band", fill: `${ESTIMATE}40`, isAt: (shut, k) => !shut[k] };
const SHUT_BAND = { label: "band if untouched", fill: hatching(), colour: `${ESTIMATE}b0`, dashes: [1.5, 1],
  isAt: (shut, k) => shut[k - 1] || shut[k] || shut[k + 1] };
const UNFILTERED = "unfiltered"; // in the label of the line behind all others
const FONT = "12px 'Source Sans 3', 'Segoe UI', Helvetica, Arial, sans-serif";

class Panel {
  constructor(data, i, stretch, scene) {
    this.forces = data.lines.map(({ label }) => scene?.forceOf(label, data.panels[i][0]));
    this.name = data.panels[i].join(" [") + "]";
    this.stretch = stretch;
    this.columns = data.columns.filter((_, column) => column % data.panels.length === i);
    this.digits = digitsOf(Math.max(...this.columns.map(({ level }) => level)) || 1);
    this.lines = data.lines.map(({ colours, dashes }) => ({ colour: colours[i] ?? colours[0], dashes }));
    this.readings = this.lines.map(() => make("span"));
    const read = this.lines.map((line, k) => make("span", {}, swatch(line), " ", this.readings[k]));
    data.lines.forEach(({ label }, k) => label.endsWith(UNFILTERED) && (read[k].style.order = 1)); // where there is room
    this.element = make("div", { className: "panel" }, make("p", {}, make("b", {}, this.name), ...read));
    const columns = this.columns.map((column) => values(column, null)), edges = columns.splice(this.lines.length);
    const parted = data.bands.flatMap(({ isAt }) => edges.map((edge) => edge.map((one, k) => (isAt(data.shut, k) ? one : null))));
    this.plot = new uPlot(this.options(data.bands), [data.times, ...columns, ...parted], this.element);
    new IntersectionObserver((entries) => {
      this.onScreen = entries.at(-1).isIntersecting;
      stretch.draw();
    }).observe(this.element);
  }

  options(bands) {
    const line = ({ colour, dashes = [] }, width) => ({ stroke: colour, width, dash: dashes.map((dash) => 2 * dash),
      points: { show: false } });
    const lines = this.lines.map((one) => line(one, 1.2)), edges = bands.flatMap((band) => [band, band]);
    const axis = { font: FONT, stroke: "#404040", grid: { stroke: "#e4e4e4", width: 1 }, ticks: { show: false } };
    const told = (unit) => (_, numbers) => numbers.map((one) => String(+one.toFixed(9)).replace("-", "−") + unit);
    return {
      width: 300,
      height: HEIGHT,
      padding: [6, 12, 0, 0],
      legend: { show: false },
      cursor: { y: false, points: { show: false }, drag: { x: false, y: false }, bind: UNBOUND },
      scales: { x: { time: false } },
      axes: [{ ...axis, size: 28, values: told(" s") }, { ...axis, size: 52, space: 25, values: told("") }],
      series: [{}, ...lines, ...edges.map((band) => line(band, 0.8))],
      bands: bands.map(({ fill }, k) => ({ series: [2, 1].map((edge) => lines.length + 2 * k + edge), fill })),
    };
  }

  draw() {
    const { plot, stretch } = this, { from, to, time } = stretch;
    if (!this.onScreen) return;
    if (this.from !== from || this.to !== to) {
      [this.from, this.to] = [from, to];
      plot.batch(() => plot.setScale("x", { min: from, max: to }));
    }
    plot.setCursor({ left: plot.valToPos(time, "x"), top: 0 }, false);
    this.readings.forEach((reading, k) => write(reading, this.text(k)));
  }

  // The value of a line at the time pointed at, as the readings beside the arm state it.
  text(line) {
    const { time } = this.stretch, force = this.forces[line];
    if (force) return withMinus(force(time), READ_DIGITS);
    return withMinus(this.plot.data[line + 1][this.plot.valToIdx(time)], this.digits);
  }

  // The values of the lines that are shown.
  told() {
    const shown = this.lines.map((_, line) => line).filter((line) => this.plot.series[line + 1].show);
    return `${this.name} ${shown.map((line) => this.text(line)).join(", ")}`;
  }

  // Show or hide a line, or a band (after the last line).
  toggle(line, show) {
    const band = line - this.lines.length, first = line + 1 + Math.max(band, 0);
    this.plot.setSeries(first, { show });
    if (band >= 0) this.plot.setSeries(first + 1, { show });
    else this.readings[line].parentElement.hidden = !show;
  }
}

const UNBOUND = Object.fromEntries(
  ["mousedown", "mouseup", "click", "dblclick", "mousemove", "mouseleave", "mouseenter"].map((name) => [name, () => null]),
);

function hatching() {
  const size = 6 * Math.ceil(window.devicePixelRatio), tile = make("canvas", { width: size, height: size }), pen = tile.getContext("2d");
  [-size, 0, size].forEach((left) => stroke(pen, [[left, size], [left + size, 0]], `${ESTIMATE}70`, size / 8));
  return pen.createPattern(tile, "repeat");
}

// A short piece of a line, or of a band, as the plots draw it.
function swatch({ colour, dashes = [], fill }) {
  const drawing = make("canvas", { className: "swatch", width: 40, height: 20, ariaHidden: "true" }), pen = drawing.getContext("2d");
  pen.scale(2, 2);
  pen.setLineDash(dashes.map((dash) => 2 * dash));
  pen.fillStyle = fill ?? "transparent";
  pen.fillRect(0, 1, 20, 8);
  const [width, heights] = fill ? [1, [1, 9]] : [2, [5]];
  heights.forEach((at) => stroke(pen, [[0, at], [20, at]], colour ?? "transparent", width));
  return drawing;
}

// A mouse points, drags across a stretch, and zooms by its wheel; a finger points, two of them zoom.
function listen(plot, stretch, carryOut) {
  const { over } = plot, down = new Map(); // places of what is down, by pointer
  const time = (place) => plot.posToVal(place, "x");
  let start = null; // of a drag
  const select = (place) =>
    plot.setSelect({ left: Math.min(start, place), width: Math.abs(place - start), top: 0, height: over.clientHeight }, false);
  const end = (event) => {
    down.delete(event.pointerId);
    if (start !== null) select(start);
    start = null;
  };
  over.onpointerdown = (event) => {
    down.set(event.pointerId, event.offsetX);
    stretch.point(time(event.offsetX));
    if (event.pointerType !== "mouse") return;
    start = event.offsetX;
    over.setPointerCapture(event.pointerId);
  };
  over.onpointermove = (event) => {
    const [other] = [...down].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    if (down.has(event.pointerId) && other !== undefined) {
      const [before, after] = [down.get(event.pointerId), event.offsetX].map((place) => Math.max(Math.abs(place - other), 20));
      stretch.zoom(before / after, time((event.offsetX + other) / 2));
    }
    if (down.has(event.pointerId)) down.set(event.pointerId, event.offsetX);
    stretch.point(time(event.offsetX));
    if (start !== null) select(event.offsetX);
  };
  over.onpointerup = (event) => {
    const across = start === null ? 0 : Math.abs(event.offsetX - start);
    if (across > 0.01 * over.clientWidth) {
      const [from, to] = [start, event.offsetX].map(time).sort((a, b) => a - b);
      carryOut(() => stretch.show(from, to));
    }
    end(event);
  };
  over.onpointercancel = end;
  over.ondblclick = () => carryOut(() => stretch.show(stretch.first, stretch.last));
  over.addEventListener("wheel", (event) => {
    if (!document.activeElement.contains(over) || document.activeElement === document.body) return; // the page scrolls
    event.preventDefault();
    stretch.zoom(Math.exp(event.deltaY / 500), time(event.offsetX));
  }, { passive: false });
}

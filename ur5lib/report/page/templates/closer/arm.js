// The arm at the time pointed at, drawn in parallel projection, with a line of time below.
"use strict";

const MARGIN = 8, SCALE = 22; // pixels, around the arm and of the scale of forces below it
const LINK = "#c3c8ce", EDGE = "#6a7078", INK = "#404040", GROUND = "#e6e6e6";
const ARROWS = { force: { colour: ESTIMATE, dashes: [], width: 4 }, sensed: { colour: "#000000", dashes: [3, 2], width: 2 } };
const BAND95 = 1.96; // standard deviations, of 95 % of a normal distribution
const TURNS = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };

class Arm {
  constructor(packed, stretch) {
    this.scene = new Scene(packed);
    this.stretch = stretch;
    stretch.view ??= this.scene.bestView();
    this.opening = this.scene.at(this.scene.busiest());
    this.largestTorque = this.scene.largestTorque();
    this.element = this.build();
    this.listen();
  }

  build() {
    const { estimate, contacts, alarms, free, force, sensed, torque } = this.scene;
    this.readings = {};
    const reading = (name, ...label) => make("p", {}, ...label, (this.readings[name] = make("span")));
    const readout = make("div", { className: "readout" }, reading("time"));
    if (force) readout.append(reading("force", swatch(ARROWS.force), ` Force x, y, z by ${estimate}: `));
    if (sensed) readout.append(reading("sensed", swatch(ARROWS.sensed), " Force sensor: "));
    if (torque) readout.append(reading("torque", `External torque of joints 1 to ${torque.length} (`, ...this.shades(), "): "));
    this.canvas = make("canvas", { tabIndex: 0, role: "application", ariaRoleDescription: "drawing of the arm" });
    this.canvas.style.setProperty("--shape", this.scene.shape(this.stretch.view, this.opening));
    this.canvas.setAttribute("aria-label", "The arm at the time pointed at, its force and the torques of its joints");
    this.button = make("button", { type: "button", onclick: () => this.stretch.play() });
    this.slider = make("input", { type: "range", step: "any", ariaLabel: "Time" });
    this.lanes = [];
    if (contacts) this.lanes.push(lane("Contact by the force sensor", "contact", contacts));
    if (alarms) this.lanes.push(lane(`${free ? "False alarm" : "Contact"} by ${estimate} (gate)`, "gate", alarms));
    const line = make("div", { className: "timeline" }, this.slider, ...this.lanes.map((one) => one.element));
    return make("div", { className: "arm" }, this.canvas, readout, make("div", { className: "player" }, this.button, line));
  }

  // The colours of joints between their ends [Nm].
  shades() {
    const colours = make("span", { className: "shades" });
    colours.style.background = `linear-gradient(to right, ${[0, 0.5, 1].map(shade)})`;
    return ["0 ", colours, ` ${Number(this.largestTorque.toPrecision(2))}\u00a0Nm`];
  }

  listen() {
    const { canvas, stretch } = this;
    canvas.onpointerdown = (event) => canvas.setPointerCapture(event.pointerId);
    canvas.onpointermove = (event) => {
      if (canvas.hasPointerCapture(event.pointerId)) this.turn(-0.01 * event.movementX, 0.01 * event.movementY);
    };
    this.slider.oninput = () => stretch.point(Number(this.slider.value));
    this.element.onkeydown = (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target === this.button) return;
      if (event.shiftKey && event.key in TURNS) this.turn(...TURNS[event.key]);
      else if (event.key === "ArrowLeft") this.step(-1);
      else if (event.key === "ArrowRight") this.step(1);
      else if (event.key === " ") stretch.play();
      else return;
      event.preventDefault();
    };
  }

  turn(turn, tilt) {
    const { view } = this.stretch;
    view.turn += turn;
    view.tilt = Math.min(Math.max(view.tilt + tilt, -Math.PI / 2), Math.PI / 2);
    this.stretch.draw();
  }

  // Go to the row after the time pointed at, or to the one before.
  step(way) {
    const { times } = this.scene, { time } = this.stretch;
    const further = times.filter((one) => way * (one - time) > 1e-6);
    if (further.length) this.stretch.point(further.at(way > 0 ? 0 : -1));
  }

  resize() {
    const { canvas } = this, sharp = window.devicePixelRatio;
    [this.wide, this.high] = [canvas.clientWidth, canvas.clientHeight];
    [canvas.width, canvas.height] = [sharp * this.wide, sharp * this.high];
    this.drawn = null;
    const pen = canvas.getContext("2d");
    pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    pen.font = FONT;
    pen.lineCap = pen.lineJoin = "round";
  }

  draw() {
    const { stretch, slider } = this, { from, to, time, view, playing } = stretch;
    if (!this.wide) return; // hidden, as in print
    const drawn = [time, view.turn, view.tilt].join();
    if (drawn !== this.drawn) this.drawPicture();
    this.drawn = drawn;
    this.lanes.forEach((one) => one.draw(stretch));
    Object.assign(slider, { min: from, max: to, value: time });
    slider.setAttribute("aria-valuetext", `${time.toFixed(2)} s`);
    write(this.button, playing ? "❚❚ Stop" : "▶ Play");
  }

  drawPicture() {
    const now = this.scene.at(this.stretch.time), pen = this.canvas.getContext("2d");
    pen.clearRect(0, 0, this.wide, this.high);
    this.aim(now);
    if (now) this.drawArm(pen, now);
    this.drawScale(pen);
    this.tell(now);
  }

  // Set the projection: its axes, its middle, that of the arm with its arrows now, and its scale [pixels/m], by which
  // these fill it, if they need not be larger than on opening.
  aim(now) {
    const { scene, opening } = this, sizes = [this.wide, this.high - SCALE];
    this.axes = projection(this.stretch.view);
    const boxes = [now ?? opening, opening].map((known) => scene.box(this.axes, known));
    this.middle = boxes[0].map(([middle]) => middle);
    this.scale = Math.min(...boxes.flatMap((box) => box.map(([, wide], i) => (sizes[i] - 2 * MARGIN) / wide)));
  }

  // Where a point [m] is in the picture.
  place(point) {
    const [right, up] = this.axes.slice(0, 2).map((axis, i) => this.scale * (dot(axis, point) - this.middle[i]));
    return [this.wide / 2 + right, (this.high - SCALE) / 2 - up];
  }

  drawArm(pen, { origins, axes, torque, force, std, sensed }) {
    const flange = origins.at(-1), nearness = (point) => dot(this.axes[2], point);
    this.drawGround(pen, origins);
    this.drawAxes(pen);
    const pieces = axes.flatMap((axis, k) => { // the drawing of each link and joint, and how near it is
      const radius = this.scene.radius(k), mark = this.scene.mark(origins[k], axis, k), ends = [origins[k], origins[k + 1]];
      const share = torque ? Math.abs(torque[k]) / this.largestTorque : NaN;
      return [[nearness(ends[0]) + nearness(ends[1]), () => this.drawCapsule(pen, ends, radius, LINK, EDGE)],
        [2 * nearness(origins[k]) + radius, () => this.drawCapsule(pen, mark, 0.8 * radius, shade(share), INK)]];
    });
    pieces.sort(([a], [b]) => a - b).forEach(([, piece]) => piece());
    this.drawNumbers(pen, axes.map((_, k) => this.place(origins[k])), origins);
    const [x, y] = this.place(flange);
    pen.fillRect(x - 4, y - 4, 8, 8);
    if (force) this.drawArrow(pen, flange, force, ARROWS.force, std);
    if (sensed) this.drawArrow(pen, flange, sensed, ARROWS.sensed);
  }

  drawCapsule(pen, ends, radius, colour, edge) {
    const points = ends.map((end) => this.place(end)), width = 2 * radius * this.scale;
    stroke(pen, points, edge, width + 2);
    stroke(pen, points, colour, width);
  }

  // A grid at the height of the base, and the arm's shadow on it.
  drawGround(pen, origins) {
    const { reach } = this.scene, step = roundNumber(reach / 3), half = step * Math.ceil(reach / step);
    for (let at = -half; at <= half + step / 2; at += step) {
      stroke(pen, [[at, -half, 0], [at, half, 0]].map((end) => this.place(end)), GROUND, 1);
      stroke(pen, [[-half, at, 0], [half, at, 0]].map((end) => this.place(end)), GROUND, 1);
    }
    stroke(pen, origins.map(([x, y]) => this.place([x, y, 0])), "#d4d4d4", THIN * reach * this.scale);
  }

  // The numbers of joints, to the left where there is no room; those in the same place stand side by side.
  drawNumbers(pen, places, origins) {
    const groups = [], beside = this.scene.radius(0) * this.scale + 8;
    places.forEach(([x, y], k) => {
      const last = groups.at(-1), joined = last && Math.hypot(...added(origins[k], origins[k - 1], -1)) < 1e-6;
      if (joined) Object.assign(last, { text: `${last.text}, ${k + 1}`, x: Math.max(last.x, x) });
      else groups.push({ text: k + 1, x, y });
    });
    groups.forEach(({ text, x, y }) => {
      const { width } = pen.measureText(text);
      label(pen, text, [x, y], x + beside + width < this.wide ? beside : -beside - width);
    });
    pen.fillStyle = INK;
  }

  // x, y and z of the base frame, in which forces are told.
  drawAxes(pen) {
    const { upright, reach } = this.scene, base = this.place([0, 0, 0]);
    ["x", "y", "z"].forEach((name, i) => {
      const end = this.place(upright.map((row) => 0.25 * reach * row[i]));
      stroke(pen, [base, end], INK, 1);
      label(pen, name, [Math.min(Math.max(end[0], 0), this.wide - 12), end[1]], 2); // at the edge, if the axis leaves
    });
  }

  // The force that acts on the flange, from there on; std: of its components, for the ellipse around its tip.
  drawArrow(pen, flange, force, { colour, width, dashes }, std = null) {
    const tip = this.tip(flange, force), start = this.place(flange), [x, y] = tip.map((one, i) => one - start[i]);
    if (!(Math.hypot(x, y) > 2)) return;
    if (std) this.drawEllipse(pen, tip, std, colour);
    pen.setLineDash(dashes.map((dash) => 2 * dash));
    stroke(pen, [start, tip], colour, width);
    pen.setLineDash([]);
    const way = Math.atan2(y, x), barb = (side) => [tip[0] - 11 * Math.cos(way + side), tip[1] - 11 * Math.sin(way + side)];
    stroke(pen, [barb(0.45), tip, barb(-0.45)], colour, width);
  }

  tip(flange, force) {
    return this.place(added(flange, this.scene.arrow(force)));
  }

  drawEllipse(pen, [x, y], std, colour) {
    const { across, along, angle } = this.ellipse(std);
    pen.beginPath();
    pen.ellipse(x, y, across, along, angle, 0, 2 * Math.PI);
    pen.fillStyle = `${colour}26`;
    pen.fill();
    pen.strokeStyle = colour;
    pen.lineWidth = 1;
    pen.stroke();
  }

  // Half-axes [pixels] and angle in the picture of the 95 % ellipse of a force: P diag(σ²) Pᵀ, P the projection.
  ellipse(std) {
    const [right, up] = product(this.axes.slice(0, 2), this.scene.upright).map((row) => row.map((one, i) => one * std[i]));
    const [xx, xy, yy] = [dot(right, right), -dot(right, up), dot(up, up)]; // the picture's y points down
    const middle = (xx + yy) / 2, half = Math.hypot((xx - yy) / 2, xy), factor = ELLIPSE * this.scene.perNewton * this.scale;
    const [across, along] = [middle + half, Math.max(middle - half, 0)].map((square) => factor * Math.sqrt(square));
    return { across, along, angle: Math.atan2(2 * xy, xx - yy) / 2 };
  }

  drawScale(pen) {
    const { scene, high } = this, newtons = roundNumber(scene.usualForce);
    if (!scene.force && !scene.sensed) return;
    stroke(pen, [[8, high - 6], [8 + newtons * scene.perNewton * this.scale, high - 6]], INK, 2);
    label(pen, `${newtons} N`, [8, high - 16], 0);
  }

  // Write what is drawn.
  tell(now) {
    const { estimate, contacts, alarms, free } = this.scene, { time } = this.stretch;
    const list = (numbers, factor = 1) => numbers.map((one) => withMinus(factor * one, READ_DIGITS)).join(", ");
    const finders = [contacts && inside(contacts, time) && "the force sensor", alarms && inside(alarms, time) && estimate];
    const found = finders.filter(Boolean).join(" and by "), isSearched = contacts || alarms;
    const isShut = alarms && !inside(alarms, time); // then the band would be that of an untouched arm
    const band = now?.std && !isShut ? `, 95 % bands ± ${list(now.std, BAND95)}` : "";
    this.readings.time.textContent =
      `At ${time.toFixed(2)} s${now ? (found ? `: ${free ? "false alarm" : "contact"} by ${found}` : isSearched ? ": no contact found" : "") : ": a gap in the recording"}.`;
    const unseen = now?.std && isShut ? "; a small push may stay unnoticed" : "";
    if (this.readings.force) this.readings.force.textContent = now ? `${list(now.force)}${band}\u00a0N${unseen}` : "–";
    if (this.readings.sensed) this.readings.sensed.textContent = now ? `${list(now.sensed)}\u00a0N` : "–";
    if (this.readings.torque) this.readings.torque.textContent = now ? `${list(now.torque)}\u00a0Nm` : "–";
  }
}

// Marks on the line of time, under their name.
function lane(name, kind, spans) {
  const marks = spans.map(() => make("i")), track = make("div", { className: `lane ${kind}` }, ...marks);
  const element = make("div", { role: "img" }, make("span", {}, name), track);
  element.setAttribute("aria-label", `${name}: ${spans.map(([from, to]) => `${from.toFixed(1)} to ${to.toFixed(1)} s`).join(", ") || "never"}`);
  const draw = ({ from, to }) => marks.forEach((mark, i) => {
    const [start, end] = spans[i].map((time) => (100 * Math.min(Math.max(time - from, 0), to - from)) / (to - from));
    Object.assign(mark.style, { left: `${start}%`, width: `${end - start}%` });
  });
  return { element, draw };
}

function stroke(pen, points, colour, width) {
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.beginPath();
  points.forEach((point) => pen.lineTo(...point));
  pen.stroke();
}

// Text to the right of a place, on a white edge.
function label(pen, text, [x, y], distance) {
  pen.fillStyle = INK;
  pen.strokeStyle = "#ffffff";
  pen.lineWidth = 3;
  pen.strokeText(text, x + distance, y + 4);
  pen.fillText(text, x + distance, y + 4);
}

// The colour of a share from 0 to 1, light to dark, also in grey; white where it is unknown.
function shade(share) {
  return Number.isNaN(share) ? "#ffffff" : `hsl(12 85% ${96 - 66 * Math.min(share, 1)}%)`;
}

// The arm at the time pointed at, drawn in parallel projection, with a line of time below.
"use strict";

const MARGIN = 8, STRIP = 56; // pixels, around the arm and below it, for the scale of forces and the axes
const LINK = "#c3c8ce", TOUCHED = "#f0e442", EDGE = "#6a7078", INK = "#404040", GROUND = "#e6e6e6";
const ARROWS = { force: { colour: ESTIMATE, dashes: [], width: 4 }, sensed: { colour: "#000000", dashes: [3, 2], width: 2 } };
const AXIS = 19, AXES = ["#e0482e", "#7aa800", "#1b3a93"]; // pixels, and colours of x, y, z, which differ in grey, too
const BAND95 = 1.96; // standard deviations, of 95 % of a normal distribution
const TURNS = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };

class Arm {
  constructor(packed, stretch, tools) {
    this.scene = new Scene(packed);
    Object.assign(this, { stretch, tools });
    stretch.view ??= this.scene.bestView();
    this.opening = this.scene.at(this.scene.busiest());
    this.largestTorque = (this.scene.torque ?? []).flat().reduce((largest, one) => Math.max(largest, Math.abs(one) || 0), 0);
    this.element = this.build();
    this.listen();
  }

  build() {
    const { estimate, force, sensed, torque } = this.scene;
    this.readings = {};
    const reading = (name, ...label) => make("p", {}, ...label, (this.readings[name] = make("span")));
    const readout = make("div", { className: "readout" });
    if (force) readout.append(reading("force", swatch(ARROWS.force), ` Force x, y, z by ${estimate}: `));
    if (sensed) readout.append(reading("sensed", swatch(ARROWS.sensed), " Force sensor: "));
    if (torque) readout.append(reading("torque", "External torque by joint (0 ", ...this.shades(), "\u00a0Nm): "));
    this.canvas = make("canvas", { tabIndex: 0, role: "application", ariaRoleDescription: "drawing of the arm" });
    this.canvas.style.setProperty("--shape", this.scene.shape(this.stretch.view, this.opening));
    this.canvas.setAttribute("aria-label", "The arm at the time pointed at, its force and the torques of its joints");
    this.button = make("button", { type: "button", onclick: () => this.stretch.play() });
    this.slider = make("input", { type: "range", step: "any", ariaLabel: "Time" });
    const line = make("div", { className: "timeline" }, this.slider, ...this.contacts());
    this.tools.prepend(this.button);
    this.tools.append(reading("time"));
    return make("div", { className: "arm" }, this.canvas, readout, make("div", { className: "player" }, this.tools, line));
  }

  // When there is contact, by the sensor and by the estimate, and what the marks mean.
  contacts() {
    const { contacts, alarms, free, estimate, link } = this.scene, what = free ? "False alarm" : "Contact";
    const missed = contacts?.filter(([from, to]) => alarms && !alarms.some(([start, end]) => start <= to && from <= end)) ?? [];
    const kinds = [["contact", "Contact by the force sensor", contacts], ["missed", `missed by ${estimate}`, missed[0] && missed],
      ["gate", `${what} by ${estimate} (gate)`, alarms], ["link", "Link that is probably touched", link?.some((one) => one > 0) && [true]]].filter(([,, spans]) => spans);
    const key = kinds.map(([kind, name, spans]) => make("span", {}, make("i", { className: kind }), ` ${name}${spans[0] ? "" : ": none"}`));
    this.lanes = kinds.filter(([kind]) => !["missed", "link"].includes(kind)).map((kind) => lane(...kind, missed));
    return [...this.lanes.map((one) => one.element), make("p", { className: "key" }, ...key)];
  }

  // The colours of joints between their ends [Nm].
  shades() {
    const colours = make("span", { className: "shades", style: `background: linear-gradient(to right, ${[0, 0.5, 1].map(shade)})` });
    return [colours, ` ${Number(this.largestTorque.toPrecision(2))}`];
  }

  listen() {
    const { canvas, stretch } = this;
    canvas.onpointerdown = (event) => canvas.setPointerCapture(event.pointerId);
    canvas.onpointermove = (event) => {
      if (canvas.hasPointerCapture(event.pointerId)) this.turn(-0.01 * event.movementX, 0.01 * event.movementY);
    };
    this.slider.oninput = () => stretch.point(Number(this.slider.value));
    this.element.onkeydown = (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("button")) return;
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
    Object.assign(pen, { font: FONT, lineCap: "round", lineJoin: "round" });
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
    write(this.button, playing ? "❚❚" : "▶");
    this.button.ariaLabel = playing ? "Stop" : "Play";
  }

  drawPicture() {
    const now = this.scene.at(this.stretch.time), pen = this.canvas.getContext("2d");
    pen.clearRect(0, 0, this.wide, this.high);
    this.aim(now);
    if (now) this.drawArm(pen, now);
    this.drawScale(pen);
    this.drawTriad(pen);
    this.tell(now);
  }

  // Set the projection: its axes, its middle, that of the arm with its arrows now, and its scale [pixels/m], by which
  // these fill it, if they need not be larger than on opening.
  aim(now) {
    const { scene, opening } = this, sizes = [this.wide, this.high - STRIP];
    this.axes = projection(this.stretch.view);
    this.known = now ?? opening;
    const boxes = [this.known, opening].map((known) => scene.box(this.axes, known));
    this.middle = boxes[0].map(([middle]) => middle);
    this.scale = Math.min(...boxes.flatMap((box) => box.map(([, wide], i) => (sizes[i] - 2 * MARGIN) / wide)));
  }

  // Where a point [m] is in the picture.
  place(point) {
    const [right, up] = this.axes.slice(0, 2).map((axis, i) => this.scale * (dot(axis, point) - this.middle[i]));
    return [this.wide / 2 + right, (this.high - STRIP) / 2 - up];
  }

  drawArm(pen, { origins, axes, torque, force, std, sensed, link, isShut }) {
    const flange = origins.at(-1), nearness = (point) => dot(this.axes[2], point);
    this.drawGround(pen, origins);
    const pieces = axes.flatMap((axis, k) => { // the drawing of each link and joint, and how near it is
      const radius = this.scene.radius(k), mark = this.scene.mark(origins[k], axis, k), ends = [origins[k], origins[k + 1]];
      const share = torque ? Math.abs(torque[k]) / this.largestTorque : NaN;
      return [[nearness(ends[0]) + nearness(ends[1]), () => this.drawCapsule(pen, ends, radius, link === k + 1 ? TOUCHED : LINK, EDGE)],
        [2 * nearness(origins[k]) + radius, () => this.drawCapsule(pen, mark, 0.8 * radius, shade(share), INK)]];
    });
    pieces.sort(([a], [b]) => a - b).forEach(([, piece]) => piece());
    this.drawNumbers(pen, axes.map((_, k) => this.place(origins[k])), origins);
    const [x, y] = this.place(flange);
    pen.fillRect(x - 4, y - 4, 8, 8);
    if (force && std) this.drawEllipse(pen, this.tip(force), isShut ? SHUT_BAND : { ...BAND, ...ARROWS.force });
    if (force) this.drawArrow(pen, flange, force, ARROWS.force);
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

  // The directions of x, y and z of the base frame, in which forces are told; the nearest last.
  drawTriad(pen) {
    const [left, top] = [this.wide - 32, this.high - 30], turned = product(this.axes, this.scene.upright);
    [0, 1, 2].sort((a, b) => turned[2][a] - turned[2][b]).forEach((i) => {
      const [right, up] = [turned[0][i], turned[1][i]], far = AXIS + 8 / (Math.hypot(right, up) || 1);
      const line = [[left, top], [left + AXIS * right, top - AXIS * up]];
      [["#ffffff", 5], [AXES[i], 3]].forEach((look) => stroke(pen, line, ...look));
      label(pen, "xyz"[i], [left + far * right, top - far * up], -3);
    });
  }

  // The force that acts on the flange, from there on.
  drawArrow(pen, flange, force, { colour, width, dashes }) {
    const tip = this.tip(force), start = this.place(flange), [x, y] = tip.map((one, i) => one - start[i]);
    if (!(Math.hypot(x, y) > 2)) return;
    pen.setLineDash(dashes.map((dash) => 2 * dash));
    stroke(pen, [start, tip], colour, width);
    pen.setLineDash([]);
    const way = Math.atan2(y, x), barb = (side) => [tip[0] - 11 * Math.cos(way + side), tip[1] - 11 * Math.sin(way + side)];
    stroke(pen, [barb(0.45), tip, barb(-0.45)], colour, width);
  }

  tip(force) {
    return this.place(this.scene.tip(this.known, force));
  }

  drawEllipse(pen, [x, y], { fill, colour, dashes }) {
    const { across, along, angle } = this.ellipse();
    pen.beginPath();
    pen.ellipse(x, y, across, along, angle, 0, 2 * Math.PI);
    Object.assign(pen, { fillStyle: fill, strokeStyle: colour, lineWidth: 1 });
    pen.fill();
    pen.setLineDash(dashes.map((dash) => 2 * dash));
    pen.stroke();
    pen.setLineDash([]);
  }

  // Half-axes [pixels] and angle in the picture of the 95 % ellipse of a force: P diag(σ²) Pᵀ, P the projection.
  ellipse() {
    const [right, up] = this.axes.slice(0, 2).map((side) => this.scene.spread(this.known, side));
    const [xx, xy, yy] = [dot(right, right), -dot(right, up), dot(up, up)]; // the picture's y points down
    const middle = (xx + yy) / 2, half = Math.hypot((xx - yy) / 2, xy), factor = ELLIPSE * this.scale;
    const [across, along] = [middle + half, Math.max(middle - half, 0)].map((square) => factor * Math.sqrt(square));
    return { across, along, angle: Math.atan2(2 * xy, xx - yy) / 2 };
  }

  drawScale(pen) {
    const { scene, high, known: { perNewton } } = this, newtons = roundNumber((0.5 * LONGEST * scene.reach) / perNewton);
    if (!scene.force && !scene.sensed) return;
    stroke(pen, [[8, high - 6], [8 + newtons * perNewton * this.scale, high - 6]], INK, 2);
    label(pen, `${newtons} N`, [8, high - 16], 0);
  }

  // Write what is drawn.
  tell(now) {
    const { estimate, contacts, alarms, largest, free } = this.scene, { time } = this.stretch;
    const { force, std, hidden, sensed, torque, link, isShut } = now ?? {};
    const list = (numbers, factor = 1) => numbers.map((one) => withMinus(factor * one, READ_DIGITS)).join(", ");
    const most = largest?.[alarms?.findIndex(([from, to]) => from <= time && time <= to)];
    const itsMost = most ? `, largest force ${withMinus(most[0], READ_DIGITS)} ± ${withMinus(most[1], READ_DIGITS)}\u00a0N` : "";
    const finders = [contacts && inside(contacts, time) && "the force sensor", alarms && inside(alarms, time) && estimate + itsMost];
    const found = finders.filter(Boolean).join(" and by "), isSearched = contacts || alarms;
    const what = !now ? "a gap in the recording" : found ? `${free ? "false alarm" : "contact"} by ${found}` : isSearched && "no contact found";
    const mayHide = hidden ? `; one of up to ${list(hidden)}\u00a0N could be hidden` : "";
    const band = std ? `, 95 % ± ${list(std, BAND95)}` : "", told = {
      time: `At ${time.toFixed(2)} s${what ? `: ${what}` : ""}${link ? `, probably on link ${link}` : ""}.`,
      force: force && (std && isShut ? `no contact found${mayHide}` : `${list(force)}${band}\u00a0N`),
      sensed: sensed && `${list(sensed)}\u00a0N`,
      torque: torque && `${list(torque)}\u00a0Nm`,
    };
    Object.entries(this.readings).forEach(([name, reading]) => write(reading, told[name] ?? "–"));
  }
}

// Marks on the line of time.
function lane(kind, name, spans, missed) {
  const marks = spans.map((span) => make("i", { className: missed.includes(span) ? "missed" : kind }));
  const element = make("div", { className: `lane ${kind}`, role: "img" }, ...marks);
  const told = spans.map((span) => `${span.map((time) => time.toFixed(1)).join(" to ")} s${missed.includes(span) ? " (missed)" : ""}`);
  element.setAttribute("aria-label", `${name}: ${told.join(", ") || "never"}`);
  const draw = ({ from, to }) => marks.forEach((mark, i) => {
    const [start, end] = spans[i].map((time) => (100 * Math.min(Math.max(time - from, 0), to - from)) / (to - from));
    Object.assign(mark.style, { left: `${start}%`, width: `${end - start}%` });
  });
  return { element, draw };
}

function stroke(pen, points, colour, width) {
  Object.assign(pen, { strokeStyle: colour, lineWidth: width });
  pen.beginPath();
  points.forEach((point) => pen.lineTo(...point));
  pen.stroke();
}

// Text to the right of a place, on a white edge.
function label(pen, text, [x, y], distance) {
  Object.assign(pen, { fillStyle: INK, strokeStyle: "#ffffff", lineWidth: 3 });
  pen.strokeText(text, x + distance, y + 4);
  pen.fillText(text, x + distance, y + 4);
}

// The colour of a share from 0 to 1, light to dark, also in grey; white where it is unknown.
function shade(share) {
  return Number.isNaN(share) ? "#ffffff" : `hsl(12 85% ${96 - 66 * Math.min(share, 1)}%)`;
}

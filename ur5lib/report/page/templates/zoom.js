// A closer look at figures over time: zoom, move, read values, hide lines and panels.
// The report is complete without it. It asks no server for anything, and changes a figure only
// when a reader wants it to. The figures of one recording show the same stretch of time.
"use strict";

const TOP = 20, PANEL = 123, STEP = 155, LEFT = 52, GUTTER = 16, BOTTOM = 28; // pixels
const NARROW = 560; // pixels, from which on panels stand side by side
const SHORTEST = 0.05; // s that can be shown
const HELP = "Keys, once the figure is selected: arrows move, plus and minus zoom, Escape shows everything. Mouse: " +
  "drag across a stretch of time to see it alone, double-click for everything; the wheel zooms a selected figure. " +
  "Grey areas and panels of errors are in the picture only.";
const COMMANDS = { // by key: the sign and name of its button, and what it does
  "+": ["+", "Zoom in", (stretch) => stretch.zoom(1 / 1.25)],
  "-": ["−", "Zoom out", (stretch) => stretch.zoom(1.25)],
  ArrowLeft: ["←", "Earlier", (stretch) => stretch.move(-0.1)],
  ArrowRight: ["→", "Later", (stretch) => stretch.move(0.1)],
  Escape: ["Everything", "Show everything", (stretch) => stretch.show(stretch.first, stretch.last)],
};
const stretches = new Map(); // by recording

// The stretch of time that the figures of a recording show, and the time pointed at [s].
class Stretch {
  first = Infinity;
  last = -Infinity;
  cursor = null;
  looks = new Set();

  add(look) {
    const everything = this.looks.size === 0 || (this.from === this.first && this.to === this.last);
    this.looks.add(look);
    this.first = Math.min(this.first, look.data.times[0]);
    this.last = Math.max(this.last, look.data.times.at(-1));
    this.show(everything ? this.first : this.from, everything ? this.last : this.to);
  }

  show(from, to) {
    const length = Math.min(Math.max(to - from, SHORTEST), this.last - this.first);
    this.from = Math.min(Math.max(from, this.first), this.last - length);
    this.to = this.from + length;
    this.draw();
  }

  zoom(factor, around = this.cursor ?? (this.from + this.to) / 2) {
    this.show(around - (around - this.from) * factor, around + (this.to - around) * factor);
  }

  move(share) {
    const step = share * (this.to - this.from);
    this.show(this.from + step, this.to + step);
  }

  point(time) {
    this.cursor = time;
    this.draw();
  }

  draw() {
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = null;
      this.looks.forEach((look) => look.draw());
    });
  }
}

function make(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

// One figure, drawn anew on a canvas.
class Look {
  constructor(figure, data) {
    const { recording } = figure.dataset;
    this.data = data;
    this.stretch = stretches.get(recording) ?? new Stretch();
    stretches.set(recording, this.stretch);
    // joints in rows, forces beside moments
    const order = data.panels[0][0].startsWith("joint") ? [0, 1, 2, 3, 4, 5] : [0, 3, 1, 4, 2, 5];
    this.panels = order.map((i) => this.choice(i, data.panels[i][0]));
    this.lines = data.lines.map((line, i) => this.choice(i, line.label, line.colours));
    this.band = data.band ? [this.choice(0, "95 % band", ["rgb(0 158 115 / 0.25)"])] : [];
    this.element = this.build(figure);
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  choice(i, label, colours = []) {
    const input = make("input", { type: "checkbox", checked: true, onchange: () => this.draw() });
    const swatches = colours.map((colour) => make("span", { className: "swatch", style: `background: ${colour}` }));
    return { i, input, element: make("label", {}, input, ...swatches, ` ${label}`) };
  }

  build(figure) {
    const help = make("p", { className: "source", id: `${figure.id}-help`, textContent: HELP });
    this.status = make("p", { className: "source", role: "status" });
    this.canvas = make("canvas", { tabIndex: 0, role: "application", ariaRoleDescription: "zoomable figure" });
    this.canvas.setAttribute("aria-label", figure.querySelector("img").alt);
    this.canvas.setAttribute("aria-describedby", help.id);
    const buttons = Object.values(COMMANDS).map(([textContent, ariaLabel, command]) =>
      make("button", { type: "button", textContent, ariaLabel, onclick: () => this.carryOut(command) }));
    const group = (name, choices) => make("fieldset", {}, make("legend", {}, name), ...choices.map((one) => one.element));
    const tools = make("div", { className: "tools" }, make("div", {}, ...buttons),
      group("Lines", [...this.lines, ...this.band]), group("Panels", this.panels));
    return make("div", { className: "closer" }, tools, this.canvas, this.status, help);
  }

  listen() {
    const { canvas, stretch } = this;
    let start = null; // of a drag
    canvas.onkeydown = (event) => {
      const command = COMMANDS[event.key === "=" ? "+" : event.key];
      if (!command || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      this.carryOut(command[2]);
    };
    canvas.onpointerdown = (event) => {
      stretch.point(this.timeAt(event));
      start = event.pointerType === "mouse" ? stretch.cursor : null; // a finger scrolls the page
    };
    canvas.onpointermove = (event) => stretch.point(this.timeAt(event));
    canvas.onpointerleave = () => stretch.point((start = null));
    canvas.onpointerup = () => {
      const [from, to] = [start ?? stretch.cursor, stretch.cursor].sort((a, b) => a - b);
      if (to - from > 0.01 * (stretch.to - stretch.from)) this.carryOut(() => stretch.show(from, to));
      start = null;
    };
    canvas.ondblclick = () => this.carryOut(COMMANDS.Escape[2]);
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return; // then the page scrolls
      event.preventDefault();
      stretch.zoom(Math.exp(event.deltaY / 500), this.timeAt(event));
    }, { passive: false });
  }

  // Carry out a command and tell what is shown then.
  carryOut(command) {
    const { data, stretch } = this;
    command(stretch);
    const time = stretch.cursor ?? (stretch.from + stretch.to) / 2;
    const read = this.chosen(this.panels).map((panel) => {
      const values = this.chosen(this.lines).map((line) => data.text(line, panel, time));
      return `${data.panels[panel][0]} ${values.join(", ")} ${data.panels[panel][1]}`;
    });
    const [from, to, at] = [stretch.from, stretch.to, time].map((seconds) => seconds.toFixed(2));
    this.status.textContent = `${from} s to ${to} s. At ${at} s: ${read.join("; ")}.`;
  }

  chosen(choices) {
    return choices.filter((one) => one.input.checked).map((one) => one.i);
  }

  // The time under a pointer.
  timeAt(event) {
    const { from, to } = this.stretch;
    const share = ((event.offsetX % this.width) - LEFT) / (this.width - LEFT);
    return from + Math.min(Math.max(share, 0), 1) * (to - from);
  }

  draw() {
    const panels = this.chosen(this.panels), room = this.canvas.clientWidth - GUTTER;
    const abreast = room < NARROW ? 1 : 2, sharp = window.devicePixelRatio;
    this.width = room / abreast; // of a panel with its labels
    this.canvas.style.height = `${Math.ceil(panels.length / abreast) * STEP + BOTTOM}px`;
    this.canvas.width = sharp * this.canvas.clientWidth; // clears it, too
    this.canvas.height = sharp * this.canvas.clientHeight;
    const pen = this.canvas.getContext("2d");
    pen.font = "12px 'Source Sans 3', 'Segoe UI', Helvetica, Arial, sans-serif";
    panels.forEach((panel, i) => {
      const across = (i % abreast) * this.width + LEFT, down = Math.floor(i / abreast) * STEP + TOP;
      pen.setTransform(sharp, 0, 0, sharp, sharp * across, sharp * down);
      const band = this.chosen(this.band).length > 0, times = i >= panels.length - abreast;
      const shown = { lines: this.chosen(this.lines), band, times };
      drawPanel(pen, this.data, panel, shown, this.stretch, this.width - LEFT, PANEL);
    });
  }
}

// Offer a closer look at a figure that holds its lines.
function offer(figure) {
  const image = figure.querySelector("img");
  const button = make("button", { type: "button", className: "look", textContent: "Look closer", ariaExpanded: "false" });
  let made = null;
  button.onclick = async () => {
    made ??= Lines.unpack(figure.querySelector("script").textContent).then((data) => new Look(figure, data));
    const look = await made, open = button.ariaExpanded === "false";
    button.ariaExpanded = String(open);
    button.textContent = open ? "Back to the picture" : "Look closer";
    image.classList.toggle("replaced", open);
    if (open) image.after(look.element);
    else look.element.remove();
    if (open) look.stretch.add(look);
    else look.stretch.looks.delete(look);
    (open ? look.canvas : button).focus({ preventScroll: true });
  };
  figure.querySelector("figcaption").before(button);
}

if ("DecompressionStream" in window) document.querySelectorAll("figure[data-recording]").forEach(offer);

// *Replay*: a figure over time to zoom into, and the arm at the time pointed at. The report is
// complete without it. It asks no server for anything.
"use strict";

const FEW = 4; // panels that stand below each other
const HELP = "Keys, once the curves are selected: arrows move, plus and minus zoom, Escape shows all; once the arm is " +
  "selected: arrows step, space plays, shift and arrows turn it. Mouse: drag across a stretch of time to see it alone, " +
  "double-click for all; the wheel zooms selected curves. Two fingers zoom. Grey areas and errors are in the still picture only.";
const COMMANDS = { // by key: the sign and name of its button, and what it does
  "+": ["+", "Zoom in", (stretch) => stretch.zoom(1 / 1.25)],
  "-": ["−", "Zoom out", (stretch) => stretch.zoom(1.25)],
  ArrowLeft: ["←", "Earlier", (stretch) => stretch.move(-0.1)],
  ArrowRight: ["→", "Later", (stretch) => stretch.move(0.1)],
  Escape: ["All", "All of it", (stretch) => stretch.show(stretch.first, stretch.last)],
};
const stretches = new Map(); // by recording

class Look {
  constructor(figure, data, scene) {
    const { recording } = figure.dataset;
    this.stretch = stretches.get(recording) ?? new Stretch();
    stretches.set(recording, this.stretch);
    let before = 0;
    data.times = values(data.time, null).map((time) => (before = time ?? before)); // null in gaps
    this.times = data.times;
    data.shut = values(data.shut, 0);
    data.bands = [BAND, SHUT_BAND].filter(({ isAt }) => data.band && data.shut.some((_, k) => isAt(data.shut, k)));
    this.tools = make("div", { className: "tools" }, ...Object.values(COMMANDS).map(([textContent, ariaLabel, command]) =>
      make("button", { type: "button", textContent, ariaLabel, title: ariaLabel, onclick: () => this.carryOut(command) })));
    this.arm = scene && new Arm(scene, this.stretch, this.tools);
    this.stretch.time ??= this.arm ? this.arm.scene.busiest() : (data.times[0] + data.times.at(-1)) / 2;
    this.panels = data.panels.map((_, i) => new Panel(data, i, this.stretch, this.arm?.scene));
    this.panels.forEach(({ plot }) => listen(plot, this.stretch, (command) => this.carryOut(command)));
    this.element = this.build(figure, data);
    new ResizeObserver(() => this.resize()).observe(this.plots);
  }

  build(figure, data) {
    const help = make("p", { className: "source", id: `${figure.id}-help`, textContent: HELP });
    this.status = make("p", { className: "source", role: "status" });
    this.plots = make("div", { className: "plots", tabIndex: 0, role: "application", ariaRoleDescription: "zoomable figure",
      onkeydown: (event) => this.press(event) }, ...this.panels.map((panel) => panel.element));
    this.plots.classList.toggle("few", this.panels.length <= FEW);
    this.plots.setAttribute("aria-label", figure.querySelector("img").alt);
    this.plots.setAttribute("aria-describedby", help.id);
    const lines = data.lines.map(({ label }, k) => ({ label, ...this.panels[0].lines[k] })).concat(data.bands);
    const shown = group("Lines", lines.map((line) => [swatch(line), line.label]),
      (k, show) => this.panels.forEach((panel) => panel.toggle(k, show)));
    const further = make("details", {}, make("summary", {}, "Panels, keys"),
      group("Panels", this.panels.map(({ name }) => [name]), (k, show) => (this.panels[k].element.hidden = !show)), help);
    const views = make("div", { className: "views" }, ...(this.arm ? [this.arm.element] : []), this.plots);
    this.choices = make("div", { className: "choices" }, ...(this.arm ? [] : [this.tools]), shown, further);
    return make("div", { className: "closer" }, views, this.choices, this.status);
  }

  press(event) {
    const command = COMMANDS[event.key === "=" ? "+" : event.key];
    if (!command || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    this.carryOut(command[2]);
  }

  // Carry out a command and tell what is shown then.
  carryOut(command) {
    const { stretch } = this;
    command(stretch);
    stretch.time = stretch.within(stretch.time);
    const read = this.panels.filter((panel) => !panel.element.hidden).map((panel) => panel.told());
    const [from, to, at] = [stretch.from, stretch.to, stretch.time].map((seconds) => seconds.toFixed(2));
    this.status.textContent = `${from} s to ${to} s. At ${at} s: ${read.join("; ")}.`;
  }

  // Beside the arm, the plots are as high as its picture.
  resize() {
    this.arm?.resize();
    const shown = this.panels.filter((panel) => panel.element.clientWidth > 0);
    const rows = new Set(shown.map((panel) => panel.element.offsetTop)).size;
    const isBeside = this.arm && this.plots.offsetTop < this.arm.canvas.offsetTop + this.arm.high;
    const height = isBeside ? Math.max(this.arm.high / rows - TITLE, LOWEST) : HEIGHT;
    shown.forEach((panel) => panel.plot.setSize({ width: panel.element.clientWidth, height }));
    this.stretch.draw(); // once uPlot has its new size
  }

  draw() {
    this.panels.forEach((panel) => panel.draw());
    this.arm?.draw();
  }
}

// Boxes to uncheck, by their labels; onChange: with the number of one, and whether it is checked.
function group(name, labels, onChange) {
  const box = (k) => make("input", { type: "checkbox", checked: true, onchange: (event) => onChange(k, event.target.checked) });
  return make("fieldset", {}, make("legend", {}, name), ...labels.map((label, k) => make("label", {}, box(k), ...label)));
}

// Offer a closer look at a figure that holds its lines; that of the first screen is open from the start.
function offer(figure) {
  const [image, caption] = [".drawing", "figcaption"].map((part) => figure.querySelector(part));
  const button = make("button", { type: "button", className: "look", ariaExpanded: "false" });
  const scene = [...document.querySelectorAll("script[data-scene]")].find((one) => one.dataset.scene === figure.dataset.recording);
  let made = null;
  const show = async (open) => {
    const packed = () => [figure.querySelector("script"), ...(scene ? [scene] : [])].map((one) => unpacked(one.textContent));
    if (open) made ??= Promise.all(packed()).then((data) => new Look(figure, ...data));
    button.ariaExpanded = String(open);
    button.textContent = open ? "Still picture" : "Replay";
    const look = await made;
    image.classList.toggle("replaced", open);
    if (open) image.after(look.element);
    else look?.element.remove();
    if (open) look.choices.append(button);
    else caption.before(button);
    if (open) look.stretch.add(look, look.times);
    else look?.stretch.remove(look);
    return look;
  };
  button.onclick = async () => {
    const open = button.ariaExpanded === "false", look = await show(open);
    (open ? look.plots : button).focus({ preventScroll: true });
    figure.scrollIntoView({ block: "nearest" });
  };
  const follow = async () => { // a link to the figure: to the second after "@", or its worst one
    const [id, second] = location.hash.slice(1).split("@");
    if (id !== figure.id) return;
    for (let fold = figure.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
    const { stretch, arm } = await show(true), time = second ? Number(second) : arm?.scene.worst();
    if (time < stretch.from || time > stretch.to) stretch.show(stretch.first, stretch.last);
    if (time !== undefined) stretch.point(time);
    figure.scrollIntoView({ block: "nearest" });
  };
  window.addEventListener("hashchange", follow);
  show("open" in figure.dataset).then(follow);
}

if ("DecompressionStream" in window) document.querySelectorAll("figure[data-recording]").forEach(offer);

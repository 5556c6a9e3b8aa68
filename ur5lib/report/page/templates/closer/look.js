// *Replay*: a figure over time to zoom into, and the arm at the time pointed at. The report is
// complete without it. It asks no server for anything.
"use strict";

const FEW = 4; // panels that stand below each other
const HELP = "Keys, once the figure is selected: arrows move, plus and minus zoom, Escape shows everything; once the " +
  "arm is selected: arrows step, space plays, shift and arrows turn the arm. Mouse: drag across a stretch of time to see " +
  "it alone, double-click for everything; the wheel zooms a selected figure; drag the arm to turn it. Two fingers zoom. " +
  "Grey areas and panels of errors are in the picture only.";
const COMMANDS = { // by key: the sign and name of its button, and what it does
  "+": ["+", "Zoom in", (stretch) => stretch.zoom(1 / 1.25)],
  "-": ["−", "Zoom out", (stretch) => stretch.zoom(1.25)],
  ArrowLeft: ["←", "Earlier", (stretch) => stretch.move(-0.1)],
  ArrowRight: ["→", "Later", (stretch) => stretch.move(0.1)],
  Escape: ["Everything", "Show everything", (stretch) => stretch.show(stretch.first, stretch.last)],
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
    this.arm = scene && new Arm(scene, this.stretch);
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
    const lines = data.lines.map(({ label }, k) => [swatch(this.panels[0].lines[k]), ` ${label}`]);
    if (data.band) lines.push(["95 % band"]);
    const tools = make("div", { className: "tools" }, ...Object.values(COMMANDS).map(([textContent, ariaLabel, command]) =>
      make("button", { type: "button", textContent, ariaLabel, onclick: () => this.carryOut(command) })));
    tools.append(group("Lines", lines.map((label, k) => choice(label, (show) => this.panels.forEach((panel) => panel.toggle(k, show))))));
    const further = make("details", {}, make("summary", {}, "Panels and keys"),
      group("Panels", this.panels.map((panel) => choice([panel.name], (show) => (panel.element.hidden = !show)))), help);
    const views = make("div", { className: "views" }, ...(this.arm ? [this.arm.element] : []), this.plots);
    return make("div", { className: "closer" }, views, tools, further, this.status);
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

function group(name, choices) {
  return make("fieldset", {}, make("legend", {}, name), ...choices);
}

function choice(label, onChange) {
  const onchange = (event) => onChange(event.target.checked);
  return make("label", {}, make("input", { type: "checkbox", checked: true, onchange }), " ", ...label);
}

// Offer a closer look at a figure that holds its lines; that of the first screen is open from the start.
function offer(figure) {
  const image = figure.querySelector(".drawing");
  const button = make("button", { type: "button", className: "look", ariaExpanded: "false" });
  const scene = [...document.querySelectorAll("script[data-scene]")].find((one) => one.dataset.scene === figure.dataset.recording);
  let made = null;
  const show = async (open) => {
    const packed = () => [figure.querySelector("script"), ...(scene ? [scene] : [])].map((one) => unpacked(one.textContent));
    if (open) made ??= Promise.all(packed()).then((data) => new Look(figure, ...data));
    button.ariaExpanded = String(open);
    button.textContent = open ? "Back to the picture" : "Replay";
    const look = await made;
    image.classList.toggle("replaced", open);
    if (open) image.after(look.element);
    else look?.element.remove();
    if (open) look.stretch.add(look, look.times);
    else look?.stretch.remove(look);
    return look;
  };
  button.onclick = async () => {
    const open = button.ariaExpanded === "false", look = await show(open);
    (open ? look.plots : button).focus({ preventScroll: true });
    figure.scrollIntoView({ block: "nearest" });
  };
  const follow = async () => { // a link to the figure: to its worst second
    if (location.hash !== `#${figure.id}`) return;
    const { stretch, arm } = await show(true);
    if (arm) stretch.point(arm.scene.worst());
    figure.scrollIntoView({ block: "nearest" });
  };
  window.addEventListener("hashchange", follow);
  figure.querySelector("figcaption").before(button);
  show("open" in figure.dataset).then(follow);
}

if ("DecompressionStream" in window) document.querySelectorAll("figure[data-recording]").forEach(offer);

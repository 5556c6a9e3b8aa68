// The lines of a figure over time, as ur5lib/report/page/render.py packed them, and how a panel of
// them is drawn. What draws gets a pen whose origin is the upper left corner of the panel's frame.
"use strict";

class Lines {
  // times [s], panels: name and unit; lines: label, colours, dashes; columns: the lines panel by
  // panel, then the edges of a band, if any.
  static async unpack(text) {
    const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
    const end = bytes.indexOf(10), codes = bytes.subarray(end + 1), half = codes.length / 2;
    const head = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end)));
    let milliseconds = 0;
    const times = Float64Array.from(head.steps, (step) => (milliseconds += step ?? 0) / 1000);
    const columns = head.ranges.map(([low, high], column) => {
      let level = 0;
      return Float32Array.from(times, (_, row) => {
        const i = column * times.length + row, code = codes[i] + 256 * codes[half + i];
        level += code % 2 ? -(code + 1) / 2 : code / 2;
        return level && head.steps[row] !== null ? low + ((level - 1) / (head.levels - 1)) * (high - low) : NaN;
      });
    });
    return Object.assign(new Lines(), head, { times, columns });
  }

  colour(line, panel) {
    const { colours } = this.lines[line];
    return colours[panel] ?? colours[0];
  }

  // The rows that show a stretch of time, one beyond each end.
  rows(from, to) {
    return [Math.max(this.after(from) - 1, 0), this.after(to) + 1];
  }

  // The first row at or after a time.
  after(time) {
    let low = 0, high = this.times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  // The row nearest to a time.
  nearest(time) {
    const next = Math.min(this.after(time), this.times.length - 1), before = Math.max(next - 1, 0);
    return time - this.times[before] < this.times[next] - time ? before : next;
  }

  // A line's value as text, with the digits that are known of its panel.
  text(line, panel, time) {
    const of = (i) => i * this.panels.length + panel;
    const widths = this.lines.map((_, i) => this.ranges[of(i)][1] - this.ranges[of(i)][0]);
    const digits = Math.ceil(Math.log10(this.levels / (Math.max(...widths) || 1)));
    const value = this.columns[of(line)][this.nearest(time)];
    return Number.isNaN(value) ? "–" : withMinus(value.toFixed(Math.min(Math.max(digits, 0), 6)));
  }
}

// A number's text with a true minus, and none before zero.
function withMinus(text) {
  return text.replace(/^-(?=.*[1-9])/, "−").replace("-", "");
}

// Round numbers between two ends, about `count` of them, with their texts.
function ticks(low, high, count) {
  const least = (high - low) / count, power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].find((size) => size * power >= least) * power;
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), first = Math.ceil(low / step);
  const numbers = Array.from({ length: Math.floor(high / step) - first + 1 }, (_, i) => (first + i) * step);
  return numbers.map((number) => [number, withMinus(number.toFixed(digits))]);
}

// The smallest and the largest value of some columns, with a margin.
function limits(columns) {
  let low = Infinity, high = -Infinity;
  for (const values of columns) {
    for (const value of values) { // every comparison with NaN is false
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  const margin = 0.05 * (high - low) || 0.001;
  return low <= high ? [low - margin, high + margin] : [0, 1];
}

// Draw a panel. shown: the lines, whether with their band, and whether with times below; stretch: the time
// from and to, and the cursor or null.
function drawPanel(pen, data, panel, shown, stretch, width, height) {
  const { from, to } = stretch, rows = data.rows(from, to), times = data.times.subarray(...rows);
  const column = (line) => data.columns[line * data.panels.length + panel].subarray(...rows);
  const lines = shown.lines.map(column);
  const edges = shown.band ? [column(data.lines.length), column(data.lines.length + 1)] : [];
  const [low, high] = limits([...lines, ...edges]);
  const x = (time) => ((time - from) / (to - from)) * width;
  const y = (value) => ((high - value) / (high - low)) * height;
  drawGrid(pen, ticks(low, high, 5), ticks(from, to, width / 70), shown.times, x, y, width, height);
  pen.save();
  pen.beginPath();
  pen.rect(0, 0, width, height);
  pen.clip();
  if (shown.band) drawBand(pen, times, ...edges, x, y);
  shown.lines.forEach((line, i) => {
    const dashes = data.lines[line].dashes.map((dash) => 1.5 * dash);
    pen.strokeStyle = data.colour(line, panel);
    pen.setLineDash(times.length < 300 ? dashes : []); // dashes of crowded lines show nothing and take long
    pen.stroke(path(times, lines[i], x, y));
  });
  pen.restore();
  drawReading(pen, data, panel, shown.lines, stretch.cursor, x, height);
}

function drawGrid(pen, values, times, timesBelow, x, y, width, height) {
  const grid = new Path2D();
  pen.fillStyle = "#404040";
  pen.textAlign = "right";
  for (const [value, text] of values) {
    grid.rect(0, y(value), width, 0);
    pen.fillText(text, -6, y(value) + 4);
  }
  pen.textAlign = "center";
  for (const [time, text] of times) {
    grid.rect(x(time), 0, 0, height);
    if (timesBelow) pen.fillText(text, x(time), height + 16);
  }
  if (timesBelow) pen.fillText("time [s]", width / 2, height + 34);
  pen.strokeStyle = "#e4e4e4";
  pen.stroke(grid);
}

function drawBand(pen, times, lower, upper, x, y) {
  pen.fillStyle = "rgb(0 158 115 / 0.25)";
  for (let i = 1; i < times.length; i++) { // where a value is NaN, nothing is drawn
    const left = x(times[i - 1]), top = y(Math.max(upper[i - 1], upper[i]));
    pen.fillRect(left, top, x(times[i]) - left, y(Math.min(lower[i - 1], lower[i])) - top);
  }
}

// The line through points; NaN breaks it.
function path(times, values, x, y) {
  const line = new Path2D();
  let broken = true;
  for (let i = 0; i < times.length; i++) {
    if (Number.isNaN(values[i])) broken = true;
    else if (broken) line.moveTo(x(times[i]), y(values[i])), (broken = false);
    else line.lineTo(x(times[i]), y(values[i]));
  }
  return line;
}

// Write what a panel shows and, at the cursor, the value of each line.
function drawReading(pen, data, panel, lines, cursor, x, height) {
  let place = 0;
  const write = (text, colour = "#1a1a1a") => {
    pen.fillStyle = colour;
    pen.fillText(text, place, -6);
    place += pen.measureText(text).width;
  };
  pen.textAlign = "left";
  write(`${data.panels[panel][0]} [${data.panels[panel][1]}]`);
  if (cursor === null) return;
  for (const line of lines) {
    write("  ● ", data.colour(line, panel));
    write(data.text(line, panel, cursor));
  }
  pen.fillStyle = "#404040";
  pen.fillRect(x(cursor), 0, 1, height);
}

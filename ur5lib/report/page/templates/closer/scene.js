// The arm of a recording as it moves, and what acts on it: postures by the poses of its links.
"use strict";

const dot = (a, b) => a.reduce((sum, one, i) => sum + one * b[i], 0);
const applied = (matrix, vector) => matrix.map((row) => dot(row, vector));
const product = (a, b) => a.map((row) => b[0].map((_, j) => dot(row, b.map((other) => other[j]))));
const added = (a, b, factor = 1) => a.map((one, i) => one + factor * b[i]);

// As ur5lib/records/scene.py describes it; its vectors are in base axes, and columns by component.
class Scene {
  constructor(packed) {
    Object.assign(this, packed);
    const unpackedColumns = (columns) => columns && columns.map((column) => values(column, NaN));
    for (const name of ["q", "torque", "force", "std", "sensed"]) this[name] = unpackedColumns(packed[name]);
    [this.times, this.segment] = [packed.time, packed.segment].map((column) => values(column, NaN));
    this.rows = [...this.times.keys()];
    this.usualForce = this.sizeOfMost([...this.sizes(this.force), ...this.sizes(this.sensed)]);
    this.reach = Math.max(...this.rows.flatMap((row) => this.originsIn(row)).map((origin) => Math.hypot(...origin) || 0));
    this.perNewton = (0.4 * this.reach) / this.usualForce; // m of an arrow
  }

  // What is known at a time, between two rows; null in a gap.
  at(time) {
    const { times, segment } = this, last = times.length - 1;
    const found = times.findIndex((one) => one >= time), next = found < 0 ? last : found, before = Math.max(next - 1, 0);
    const share = Math.min(Math.max((time - times[before]) / (times[next] - times[before]), 0), 1) || 0;
    if (segment[before] !== segment[next] && share > 0 && share < 1) return null;
    const between = (columns) => columns && columns.map((column) => column[before] + share * (column[next] - column[before]));
    const [q, torque, force, std, sensed] = [this.q, this.torque, this.force, this.std, this.sensed].map(between);
    return { ...this.posture(q), torque, force, std, sensed };
  }

  // Origins of frames 0 to n and the axes of the joints at angles q; z points up.
  posture(q) {
    let turned = this.upright, origin = [0, 0, 0];
    const origins = [origin], axes = [];
    this.links.forEach(({ rotation, position }, k) => {
      const [c, s] = [Math.cos(q[k]), Math.sin(q[k])];
      axes.push(turned.map((row) => row[2]));
      turned = turned.map(([x, y, z]) => [c * x + s * y, c * y - s * x, z]);
      origin = added(origin, applied(turned, position));
      turned = product(turned, rotation);
      origins.push(origin);
    });
    return { origins, axes };
  }

  originsIn(row) {
    return this.posture(this.q.map((column) => column[row])).origins;
  }

  arrow(force) {
    return applied(this.upright, force).map((one) => this.perNewton * one);
  }

  // Ends of the arrows of a row, without those longer than most.
  tipsIn(row, flange) {
    const forces = [this.force, this.sensed].filter(Boolean).map((columns) => columns.map((column) => column[row]));
    return forces.filter((force) => Math.hypot(...force) <= this.usualForce).map((force) => added(flange, this.arrow(force)));
  }

  // The upright cylinder [m] in which the arm and its arrows move: middle, radius, half its height.
  room() {
    const inRow = (row, origins) => [...origins, ...this.tipsIn(row, origins.at(-1))];
    const points = this.rows.flatMap((row) => inRow(row, this.originsIn(row))).filter(([x]) => !Number.isNaN(x));
    const ends = [0, 1, 2].map((i) => [Math.min, Math.max].map((end) => points.reduce((found, point) => end(found, point[i]), points[0][i])));
    const middle = ends.map(([from, to]) => (from + to) / 2);
    const radius = points.reduce((found, [x, y]) => Math.max(found, Math.hypot(x - middle[0], y - middle[1])), 0);
    return { middle, radius, half: ends[2][1] - middle[2] };
  }

  // Sizes of a vector in each row, 0 where it is unknown.
  sizes(columns) {
    return columns ? this.rows.map((row) => Math.hypot(...columns.map((column) => column[row])) || 0) : [];
  }

  // The size that few are larger than, at least 10 [N].
  sizeOfMost(sizes) {
    return Math.max(sizes.sort((a, b) => a - b)[Math.floor(0.99 * sizes.length)] ?? 0, 10);
  }

  largestTorque() {
    return (this.torque ?? []).flat().reduce((largest, one) => Math.max(largest, Math.abs(one) || 0), 0);
  }

  // The time of the largest force, or the middle.
  busiest() {
    const sizes = this.sizes(this.sensed ?? this.force), middle = Math.floor(this.times.length / 2);
    return this.times[sizes.reduce((best, size, row) => (size > sizes[best] ? row : best), middle)];
  }
}

const inside = (spans, time) => spans.some(([from, to]) => from <= time && time <= to);

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

  // Middle and radius [m] of the ball in which the arm moves.
  room() {
    const points = this.rows.flatMap((row) => this.posture(this.q.map((column) => column[row])).origins);
    const known = points.filter(([x]) => !Number.isNaN(x));
    const end = (choose, i) => known.reduce((found, point) => choose(found, point[i]), known[0][i]);
    const middle = [0, 1, 2].map((i) => (end(Math.min, i) + end(Math.max, i)) / 2);
    return { middle, radius: known.reduce((found, point) => Math.max(found, Math.hypot(...added(point, middle, -1))), 0) };
  }

  // Sizes of a vector in each row, 0 where it is unknown.
  sizes(columns) {
    return columns ? this.rows.map((row) => Math.hypot(...columns.map((column) => column[row])) || 0) : [];
  }

  // The size of force [N] that an arrow must have room for: few are larger.
  usualForce() {
    const sizes = [...this.sizes(this.force), ...this.sizes(this.sensed)].sort((a, b) => a - b);
    return Math.max(sizes[Math.floor(0.99 * sizes.length)] ?? 0, 10);
  }

  largestTorque() {
    return (this.torque ?? []).flat().reduce((largest, one) => Math.max(largest, Math.abs(one) || 0), 0);
  }

  // The time of the largest force, or the middle.
  busiest() {
    const sizes = this.sizes(this.force ?? this.sensed), middle = Math.floor(this.times.length / 2);
    return this.times[sizes.reduce((best, size, row) => (size > sizes[best] ? row : best), middle)];
  }
}

const inside = (spans, time) => spans.some(([from, to]) => from <= time && time <= to);

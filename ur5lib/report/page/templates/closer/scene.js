// The arm of a recording as it moves, and what acts on it: postures by the poses of its links.
"use strict";

const ELLIPSE = Math.sqrt(-2 * Math.log(0.05)); // standard deviations, of 95 % of a plane's normal distribution
const THICK = 0.05, THIN = 0.03; // radii of the first and the last link, shares of the reach
const NARROWEST = 0.45, WIDEST = 1.5; // width over height of the picture
const LEAST_TILT = 0.2, MOST_TILT = 1.2; // rad: the ground stays in sight, and so does what is upright
const LONGEST = 0.3; // of the reach, of an arrow with its ellipse
const dot = (a, b) => a.reduce((sum, one, i) => sum + one * b[i], 0);
const applied = (matrix, vector) => matrix.map((row) => dot(row, vector));
const product = (a, b) => a.map((row) => b[0].map((_, j) => dot(row, b.map((other) => other[j]))));
const added = (a, b, factor = 1) => a.map((one, i) => one + factor * b[i]);

// As ur5lib/records/scene.py describes it; its vectors are in base axes, and columns by component.
class Scene {
  constructor(packed) {
    Object.assign(this, packed);
    const unpackedColumns = (columns) => columns && columns.map((column) => values(column, NaN));
    for (const name of ["q", "torque", "force", "std", "hidden", "sensed"]) this[name] = unpackedColumns(packed[name]);
    this.link = packed.link && values(packed.link, NaN);
    [this.times, this.segment] = [packed.time, packed.segment].map((column) => values(column, NaN));
    this.rows = [...this.times.keys()];
    this.path = this.rows.flatMap((row) => this.originsIn(row)).filter(([x]) => !Number.isNaN(x));
    this.reach = this.path.reduce((reach, origin) => Math.max(reach, Math.hypot(...origin)), 0);
    const acting = (row) => [this.force, this.std, this.sensed].map((columns) => columns?.map((column) => column[row]));
    const lengths = this.rows.map((row) => this.length(...acting(row))).sort((a, b) => a - b);
    this.usual = Math.max(lengths[Math.floor(0.99 * lengths.length)], 10); // N, that few arrows are longer than
  }

  // What is known at a time, between two rows; null in a gap.
  at(time) {
    if (this.latest?.time !== time) this.latest = { time, known: this.knownAt(time) };
    return this.latest.known;
  }

  // By the label of a line and the name of its panel, a function of the time: the force that the readings beside
  // the arm state, too; undefined of all else.
  forceOf(label, panel) {
    const name = { [this.estimate]: "force", "force sensor": "sensed" }[label], axis = ["Fx", "Fy", "Fz", "size"].indexOf(panel);
    if (!name || !this[name] || axis < 0) return undefined;
    const read = (force) => (force ? [...force, Math.hypot(...force)][axis] : null);
    return (time) => read(this.at(time)?.[name]);
  }

  knownAt(time) {
    const { times, segment } = this, last = times.length - 1;
    const found = times.findIndex((one) => one >= time), next = found < 0 ? last : found, before = Math.max(next - 1, 0);
    const share = Math.min(Math.max((time - times[before]) / (times[next] - times[before]), 0), 1) || 0;
    if (segment[before] !== segment[next] && share > 0 && share < 1) return null;
    const between = (columns) => columns && columns.map((column) => column[before] + share * (column[next] - column[before]));
    const [q, torque, force, std, hidden, sensed] = [this.q, this.torque, this.force, this.std, this.hidden, this.sensed].map(between);
    const isShut = Boolean(force) && Math.max(...force.map(Math.abs)) < 0.005; // N: it is zero where no contact is found
    const perNewton = (LONGEST * this.reach) / Math.max(this.usual, this.length(force, std, sensed)); // m; less for the longest
    const link = this.link?.[next]; // that is touched before the last one, if any
    return { ...this.posture(q), torque, force, std, hidden, sensed, link, isShut, perNewton };
  }

  // Of the longer arrow, that of the estimate with its ellipse [N].
  length(force, std, sensed) {
    const [own, read] = [force, sensed].map((one) => Math.hypot(...(one ?? [])) || 0);
    return Math.max(own + (ELLIPSE * Math.max(0, ...(std ?? [])) || 0), read);
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

  // The tip [m] of the arrow of a force on the flange.
  tip({ origins, perNewton }, force) {
    return added(origins.at(-1), applied(this.upright, force), perNewton);
  }

  // Standard deviations [m] of a tip along an axis of the picture, by component of the force.
  spread({ std, perNewton }, side) {
    return product([side], this.upright)[0].map((one, i) => perNewton * one * std[i]);
  }

  // Of link k and its joint [m].
  radius(k) {
    return this.reach * (THICK + ((THIN - THICK) * k) / this.links.length);
  }

  // The ends of what is drawn of joint k.
  mark(origin, axis, k) {
    return [-1, 1].map((way) => added(origin, axis, way * this.radius(k)));
  }

  // Middle and width [m], along axes of the picture, of an arm with its arrows and their ellipse.
  box(picture, known) {
    const { origins, axes, force, std, sensed } = known, radius = this.radius(0);
    const marks = axes.flatMap((axis, k) => this.mark(origins[k], axis, k));
    return picture.slice(0, 2).map((side) => {
      const around = (points, half) => points.flatMap((point) => [dot(side, point) - half, dot(side, point) + half]);
      const tips = [force, sensed].map((one, k) => one?.every(Number.isFinite)
        ? around([this.tip(known, one)], (k === 0 && std && ELLIPSE * Math.hypot(...this.spread(known, side))) || 0) : []);
      const along = [...around([...origins, ...marks], radius), ...tips.flat()], ends = [Math.min(...along), Math.max(...along)];
      return [(ends[0] + ends[1]) / 2, ends[1] - ends[0]];
    });
  }

  // Width over height of the picture that an arm fills.
  shape(view, known) {
    const [wide, high] = this.box(projection(view), known).map(([, width]) => width);
    return Math.min(Math.max(wide / high, NARROWEST), WIDEST);
  }

  // From where the arm is seen best [rad]: along the normal of the mean plane of its path, from above.
  bestView() {
    const { path } = this, middle = [0, 1, 2].map((i) => path.reduce((sum, point) => sum + point[i], 0) / path.length);
    const apart = path.map((point) => added(point, middle, -1));
    const spread = [0, 1, 2].map((i) => [0, 1, 2].map((j) => -apart.reduce((sum, point) => sum + point[i] * point[j], 0)));
    const whole = -spread.reduce((sum, row, i) => sum + row[i], 0) || 1;
    spread.forEach((row, i) => (row[i] += whole)); // its largest eigenvalue is that of the least spread
    let normal = [1, 0.9, 0.8];
    for (let i = 0; i < 100; i++) {
      normal = applied(spread, normal);
      normal = normal.map((one) => one / Math.hypot(...normal));
    }
    const [x, y, z] = normal.map((one) => one * (normal[2] < 0 ? -1 : 1));
    return { turn: Math.atan2(y, x), tilt: Math.min(Math.max(Math.asin(z), LEAST_TILT), MOST_TILT) };
  }

  // Sizes of a vector in each row, 0 where it is unknown.
  sizes(columns) {
    return columns ? this.rows.map((row) => Math.hypot(...columns.map((column) => column[row])) || 0) : [];
  }

  // The time of the largest error beside the sensor, or of the largest force.
  worst() {
    const { force, sensed } = this;
    if (!force || !sensed) return this.busiest();
    const errors = this.sizes(force.map((column, i) => column.map((one, row) => one - sensed[i][row])));
    return this.times[errors.indexOf(Math.max(...errors))];
  }

  // The time of the largest force, or the middle.
  busiest() {
    const sizes = this.sizes(this.sensed ?? this.force), middle = Math.floor(this.times.length / 2);
    return this.times[sizes.reduce((best, size, row) => (size > sizes[best] ? row : best), middle)];
  }
}

const inside = (spans, time) => spans.some(([from, to]) => from <= time && time <= to);

// The axes to the right, upwards and out of the picture.
function projection({ turn, tilt }) {
  const [c, s] = [Math.cos(turn), Math.sin(turn)], [ct, st] = [Math.cos(tilt), Math.sin(tilt)];
  return [[-s, c, 0], [-st * c, -st * s, ct], [ct * c, ct * s, st]];
}

// The stretch of time [s] that all figures of a recording show, the time pointed at, and what plays it.
"use strict";

const SHORTEST = 0.05; // s that can be shown

class Stretch {
  first = Infinity;
  last = -Infinity;
  time = null;
  playing = false;
  view = null; // from where the arm is seen, turn and tilt [rad]
  looks = new Set();

  add(look, times) {
    const everything = this.looks.size === 0 || (this.from === this.first && this.to === this.last);
    this.looks.add(look);
    this.first = Math.min(this.first, times[0]);
    this.last = Math.max(this.last, times.at(-1));
    this.show(everything ? this.first : this.from, everything ? this.last : this.to);
  }

  remove(look) {
    this.looks.delete(look);
    this.playing &&= this.looks.size > 0;
  }

  show(from, to) {
    const length = Math.min(Math.max(to - from, SHORTEST), this.last - this.first);
    this.from = Math.min(Math.max(from, this.first), this.last - length);
    this.to = this.from + length;
    this.draw();
  }

  zoom(factor, around = this.within(this.time)) {
    this.show(around - (around - this.from) * factor, around + (this.to - around) * factor);
  }

  move(share) {
    const step = share * (this.to - this.from);
    this.show(this.from + step, this.to + step);
  }

  point(time) {
    this.time = this.within(time);
    this.draw();
  }

  within(time) {
    return Math.min(Math.max(time, this.from), this.to);
  }

  // Play what is shown, at the speed of the recording, or stop.
  play() {
    this.playing = !this.playing;
    if (this.playing && this.within(this.time) >= this.to) this.time = this.from;
    let before = performance.now();
    const go = (now) => {
      if (!this.playing) return;
      this.playing = this.time < this.to;
      this.point(this.time + Math.max(now - before, 0) / 1000);
      before = now;
      requestAnimationFrame(go);
    };
    requestAnimationFrame(go);
    this.draw();
  }

  draw() {
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = null;
      this.looks.forEach((look) => look.draw());
    });
  }
}

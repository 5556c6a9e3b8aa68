// Numbers as ur5lib/report/page/closer.py packed them, and as text.
"use strict";

async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).json();
}

function values({ low, level, steps }, unknown) {
  let levels = 0;
  return steps.map((step) => (step === null ? unknown : low + level * (levels += step)));
}

// The digits after the point that are known of values in levels of this distance.
function digitsOf(level) {
  return Math.min(Math.max(Math.ceil(-Math.log10(level)), 0), 6);
}

const READ_DIGITS = 1; // after the point, of forces and torques at a time

function withMinus(value, digits) {
  if (value === null || Number.isNaN(value)) return "–";
  return value.toFixed(digits).replace(/^-(?=.*[1-9])/, "−").replace("-", ""); // none before zero
}

// The largest of 1, 2, 5, 10, 20, … that a positive number reaches.
function roundNumber(number) {
  const power = 10 ** Math.floor(Math.log10(number));
  return power * [5, 2, 1].find((size) => size * power <= number * (1 + 1e-9));
}

// Change a text where it differs, since each change costs a layout.
function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function make(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

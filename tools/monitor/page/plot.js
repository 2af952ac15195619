// Shared by both history plots: time on the x axis, the newest on the right.

import { colour } from "./palette.js";
import { duration } from "./format.js";

const TIMES = [10, 30, 60, 120, 300, 600, 1200, 3600];
const BOTTOM = 16; // px under the axis

export function timeAxis(surface, left, span, wall) {
  const right = surface.width - 4;
  const bottom = surface.height - BOTTOM;
  const x = (time) => right - ((wall - time) / span) * (right - left);
  return { left, right, bottom, top: 4, x, from: wall - span };
}

export function drawTimeAxis(context, axis, span) {
  const step = TIMES.find((time) => span / time <= 5) ?? 3600;
  context.font = "10.5px system-ui, 'DejaVu Sans', sans-serif";
  context.fillStyle = colour("quiet");
  context.strokeStyle = colour("line");
  context.lineWidth = 1;
  context.textAlign = "center";
  context.beginPath();
  for (let ago = step; ago < span; ago += step) {
    const x = Math.round(axis.right - (ago / span) * (axis.right - axis.left)) + 0.5;
    context.moveTo(x, axis.top);
    context.lineTo(x, axis.bottom);
    context.fillText(`−${duration(ago)}`, x, axis.bottom + 12);
  }
  context.moveTo(axis.left, axis.bottom + 0.5);
  context.lineTo(axis.right, axis.bottom + 0.5);
  context.stroke();
}

// Draws clipped to the axes.
export function drawWithin(context, axis, draw) {
  context.save();
  context.beginPath();
  context.rect(axis.left, 0, axis.right - axis.left, axis.bottom + 1);
  context.clip();
  draw();
  context.restore();
}

// Returns the index of the last sample before ``from``, or 0; samples are in order of time.
export function firstInView(samples, from) {
  let [low, high] = [0, samples.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (samples[middle][0] < from) low = middle + 1;
    else high = middle;
  }
  return Math.max(low - 1, 0);
}

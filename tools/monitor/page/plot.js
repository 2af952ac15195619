// Shared by both history plots: time on the x axis, cursor and present as lines.

import { duration, timeOfDay } from "./format.js";
import { colour } from "./palette.js";

const TIMES = [10, 30, 60, 120, 300, 600, 1200, 3600, 7200, 21600, 86400];
const BOTTOM = 16; // px under the axis
export const GAP = 3; // s without a sample that breaks a line

// window: as History.window returns it.
export function timeAxis(surface, left, window) {
  const { from, to, present } = window;
  const right = surface.width - 16;
  const bottom = surface.height - BOTTOM;
  const x = (time) => left + ((time - from) / (to - from)) * (right - left);
  const time = (px) => Math.min(Math.max(from + ((px - left) / (right - left)) * (to - from), from), to);
  return { left, right, bottom, top: 4, x, time, from, to, present };
}

// Times before the present where that is the end, else times of the day.
export function drawTimeAxis(context, axis) {
  const span = axis.to - axis.from;
  const step = TIMES.find((time) => span / time <= 5) ?? 86400;
  const live = axis.present >= axis.to;
  context.font = "10.5px system-ui, 'DejaVu Sans', sans-serif";
  context.fillStyle = colour("quiet");
  context.strokeStyle = colour("line");
  context.lineWidth = 1;
  context.textAlign = "center";
  context.beginPath();
  const first = live ? axis.to - Math.floor(span / step) * step : Math.ceil(axis.from / step) * step;
  for (let time = first; time < axis.to - (live ? step / 2 : 0); time += step) {
    const x = Math.round(axis.x(time)) + 0.5;
    if (x < axis.left + 8 || x > axis.right) continue;
    context.moveTo(x, axis.top);
    context.lineTo(x, axis.bottom);
    context.fillText(live ? `−${duration(axis.to - time)}` : timeOfDay(time), x, axis.bottom + 12);
  }
  context.moveTo(axis.left, axis.bottom + 0.5);
  context.lineTo(axis.right, axis.bottom + 0.5);
  context.stroke();
}

// The present of a playback within the time shown, and the cursor; cursor: s since 1970 or null.
export function drawTimes(context, axis, cursor) {
  if (axis.present < axis.to) line(context, axis, axis.present, colour("accent"), 2);
  if (cursor !== null && cursor >= axis.from && cursor <= axis.to) line(context, axis, cursor, colour("text"), 1);
}

function line(context, axis, time, style, width) {
  context.strokeStyle = style;
  context.lineWidth = width;
  context.beginPath();
  context.moveTo(axis.x(time), axis.top);
  context.lineTo(axis.x(time), axis.bottom);
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

// Returns the sample nearest to a time, undefined if it is far from all.
export function sampleAt(samples, time) {
  const first = firstInView(samples, time);
  const near = samples.slice(first, first + 2).sort((a, b) => Math.abs(a[0] - time) - Math.abs(b[0] - time))[0];
  return near && Math.abs(near[0] - time) <= GAP ? near : undefined;
}

// Writes robots' numbers at the right end of their lines, those only that do not overprint.
export function drawMarks(context, axis, marks) {
  context.font = "600 10px system-ui, 'DejaVu Sans', sans-serif";
  context.textAlign = "left";
  const taken = [];
  for (const { words, y, style } of marks) {
    if (taken.some((other) => Math.abs(other - y) < 9)) continue;
    taken.push(y);
    context.fillStyle = style;
    context.fillText(words, axis.right + 2, y + 3.5);
  }
}

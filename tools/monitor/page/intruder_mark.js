// An intruder's last place on the map with its age, for as long as its alarm is listed.

import { duration } from "./format.js";
import { colour } from "./palette.js";

const NOW = 2.5; // s within which an intruder is seen at present: reports come once a second

// The pixels that mark and words take, as [x0, y0, x1, y1].
export function intruderBox(alarm, viewport) {
  const [px, py] = viewport.toPixel(...alarm.place);
  return [px - 65, py - 11, px + 65, py + 23];
}

export function drawIntruder(context, alarm, viewport, wall) {
  const [px, py] = viewport.toPixel(...alarm.place);
  const age = Math.max(wall - alarm.seen, 0);
  const words = age < NOW ? "intruder" : `intruder, ${duration(age)} ago`;
  context.beginPath();
  context.moveTo(px, py - 9);
  context.lineTo(px + 8, py + 6);
  context.lineTo(px - 8, py + 6);
  context.closePath();
  context.lineJoin = "round";
  context.strokeStyle = colour("floor");
  context.lineWidth = 5;
  context.stroke();
  context.fillStyle = context.strokeStyle = colour("critical");
  context.lineWidth = 2;
  if (age < NOW) context.fill();
  context.stroke();
  context.font = "600 12px system-ui, 'DejaVu Sans', sans-serif";
  context.textAlign = "center";
  context.lineWidth = 3.5;
  context.strokeStyle = colour("floor");
  context.strokeText(words, px, py + 19);
  context.fillText(words, px, py + 19);
}

// Every robot's distance from the border over time (the paper's first figure, live).

import { setText } from "./element.js";
import { quantity, timeOfDay } from "./format.js";
import { colour, robotColour } from "./palette.js";
import { drawMarks, drawTimeAxis, drawTimes, drawWithin, firstInView, GAP, timeAxis } from "./plot.js";
import { Surface } from "./surface.js";

const SCALES = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
const LEFT = 34; // px
const READ = 6; // robots whose values are told at the cursor

export class DistancePlot {
  constructor(canvas, words, history, selection, cursor) {
    this.words = words;
    this.history = history;
    this.selection = selection;
    this.cursor = cursor;
    this.surface = new Surface(canvas, () => this.draw());
    cursor.listen(canvas, () => this.axis());
  }

  axis() {
    return timeAxis(this.surface, LEFT, this.history.window());
  }

  draw() {
    if (!this.surface.width) return;
    const context = this.surface.begin();
    const axis = this.axis();
    const lines = this.history.roster.plotted().map((robot) => {
      const samples = this.history.samples(robot);
      return { robot, samples, first: firstInView(samples, axis.from), end: firstInView(samples, axis.to) + 2 };
    });
    const top = scaleFor(lines);
    const y = (distance) => axis.bottom - (Math.min(distance, top) / top) * (axis.bottom - axis.top - 4);
    drawTimeAxis(context, axis);
    this.drawScale(context, axis, top, y);
    drawWithin(context, axis, () => {
      for (const line of lines) this.drawLine(context, line, axis, y);
      drawTimes(context, axis, this.cursor.time);
    });
    drawMarks(context, axis, lines.flatMap(({ robot, samples, end }) => {
      const last = samples[Math.min(end, samples.length) - 1];
      return last && axis.to - last[0] < 2 * GAP ? [{ words: robot.mark, y: y(last[3]), style: robotColour(robot.number) }] : [];
    }));
    this.tell();
  }

  // Tells the values at the cursor, the largest first.
  tell() {
    const { time } = this.cursor;
    if (time === null) return setText(this.words, "");
    const found = this.history.at(time).sort(([, a], [, b]) => b[3] - a[3]);
    const values = found.slice(0, READ).map(([robot, sample]) => `${robot.label} ${quantity(sample[3], "m")}`);
    return setText(this.words, [timeOfDay(time), ...values].join(" · "));
  }

  drawScale(context, axis, top, y) {
    context.textAlign = "right";
    context.fillStyle = colour("quiet");
    context.strokeStyle = colour("line");
    for (const value of [0, top / 2, top]) {
      const at = Math.round(y(value)) + 0.5;
      context.fillText(String(Number(value.toPrecision(2))), axis.left - 5, at + 3.5);
      if (!value) continue;
      context.beginPath();
      context.moveTo(axis.left, at);
      context.lineTo(axis.right, at);
      context.stroke();
    }
  }

  drawLine(context, { robot, samples, first, end }, axis, y) {
    const chosen = robot.id === this.selection.id;
    context.strokeStyle = robotColour(robot.number);
    context.lineWidth = chosen ? 2.2 : 1.5;
    context.globalAlpha = this.selection.id && !chosen ? 0.55 : 1;
    context.beginPath();
    let before = -Infinity;
    for (let at = first; at < Math.min(end, samples.length); at += 1) {
      const [wall, , , distance] = samples[at];
      if (wall - before > GAP) context.moveTo(axis.x(wall), y(distance));
      else context.lineTo(axis.x(wall), y(distance));
      before = wall;
    }
    context.stroke();
    context.globalAlpha = 1;
  }
}

function scaleFor(lines) {
  let largest = 0;
  for (const { samples, first, end } of lines) {
    for (let at = first; at < Math.min(end, samples.length); at += 1) largest = Math.max(largest, samples[at][3]);
  }
  return SCALES.find((scale) => scale >= largest) ?? largest;
}

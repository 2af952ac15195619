// Every robot's distance from the border over time (the paper's first figure, live).

import { colour, robotColour } from "./palette.js";
import { drawTimeAxis, drawWithin, firstInView, timeAxis } from "./plot.js";
import { Surface } from "./surface.js";

const SCALES = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
const GAP = 3; // s without a sample that breaks the line

export class DistancePlot {
  constructor(canvas, team, roster, selection) {
    this.team = team;
    this.roster = roster;
    this.selection = selection;
    this.surface = new Surface(canvas, () => this.draw());
    this.span = 300;
  }

  draw() {
    if (!this.surface.width) return;
    const context = this.surface.begin();
    const axis = timeAxis(this.surface, 34, this.span, this.team.wall);
    const lines = this.roster.plotted().map((robot) => [robot, firstInView(robot.samples, axis.from)]);
    const top = this.scaleFor(lines);
    drawTimeAxis(context, axis, this.span);
    const y = (distance) => axis.bottom - (Math.min(distance, top) / top) * (axis.bottom - axis.top - 4);
    this.drawScale(context, axis, top, y);
    drawWithin(context, axis, () => {
      for (const [robot, first] of lines) this.drawLine(context, robot, first, axis, y);
    });
  }

  scaleFor(lines) {
    let largest = 0;
    for (const [robot, first] of lines) {
      for (let at = first; at < robot.samples.length; at += 1) largest = Math.max(largest, robot.samples[at][3]);
    }
    return SCALES.find((scale) => scale >= largest) ?? largest;
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

  drawLine(context, robot, first, axis, y) {
    const chosen = robot.id === this.selection.id;
    context.strokeStyle = robotColour(robot.number);
    context.lineWidth = chosen ? 2.2 : 1.5;
    context.globalAlpha = this.selection.id && !chosen ? 0.55 : 1;
    context.beginPath();
    let before = -Infinity;
    for (let at = first; at < robot.samples.length; at += 1) {
      const [wall, , , distance] = robot.samples[at];
      if (wall - before > GAP) context.moveTo(axis.x(wall), y(distance));
      else context.lineTo(axis.x(wall), y(distance));
      before = wall;
    }
    context.stroke();
    context.globalAlpha = 1;
  }
}

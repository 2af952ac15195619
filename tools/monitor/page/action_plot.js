// Every robot's action over time (the paper's second figure, live): one lane per action.

import { colour, robotColour } from "./palette.js";
import { drawTimeAxis, drawWithin, firstInView, timeAxis } from "./plot.js";
import { Surface } from "./surface.js";

const LANES = ["Reach", "Keep", "Cw", "Ccw", "Avoid"];
const GAP = 3; // s without a sample that breaks the line

export class ActionPlot {
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
    const axis = timeAxis(this.surface, 44, this.span, this.team.wall);
    drawTimeAxis(context, axis, this.span);
    const height = (axis.bottom - axis.top) / LANES.length;
    context.textAlign = "right";
    LANES.forEach((name, lane) => {
      context.fillStyle = colour("quiet");
      context.fillText(name, axis.left - 6, axis.top + (lane + 0.5) * height + 3.5);
    });
    drawWithin(context, axis, () => this.drawRobots(context, axis, height));
  }

  drawRobots(context, axis, height) {
    const robots = this.roster.plotted();
    const thickness = Math.min(Math.max((height - 4) / Math.max(robots.length, 1), 1), 5);
    robots.forEach((robot, row) => {
      const offset = 2 + (row * Math.max(height - 4 - thickness, 0)) / Math.max(robots.length - 1, 1);
      this.drawRobot(context, robot, axis, height, offset, thickness);
    });
  }

  drawRobot(context, robot, axis, height, offset, thickness) {
    const { samples } = robot;
    context.fillStyle = robotColour(robot.number);
    context.globalAlpha = this.selection.id && robot.id !== this.selection.id ? 0.55 : 1;
    let at = firstInView(samples, axis.from);
    while (at < samples.length) {
      const [start, , , , action] = samples[at];
      let end = start;
      while (at < samples.length && samples[at][4] === action && samples[at][0] - end <= GAP) {
        end = samples[at][0];
        at += 1;
      }
      const next = at < samples.length && samples[at][0] - end <= GAP ? samples[at][0] : end + 1;
      if (action >= 0) {
        const [x0, x1] = [axis.x(start), axis.x(next)];
        context.fillRect(x0, axis.top + action * height + offset, Math.max(x1 - x0, 1), thickness);
      }
    }
    context.globalAlpha = 1;
  }
}

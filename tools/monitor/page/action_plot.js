// Every robot's action over time (the paper's second figure, live).
//
// Few robots: one lane per action, lines in the robots' colours. Many: one row per robot, in the actions' colours.

import { setText } from "./element.js";
import { actionName, timeOfDay } from "./format.js";
import { colour, robotColour } from "./palette.js";
import { drawTimeAxis, drawTimes, drawWithin, firstInView, GAP, timeAxis } from "./plot.js";
import { Surface } from "./surface.js";

export const LANES = ["Reach", "Keep", "Cw", "Ccw", "Avoid"];
const FEW = 6;
const LEFT = 44; // px
const READ = 6; // robots whose actions are told at the cursor

export class ActionPlot {
  constructor(canvas, words, legend, actions, history, selection, cursor) {
    this.words = words;
    this.legend = legend;
    this.actions = actions;
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
    const robots = this.history.roster.plotted();
    const rows = robots.length > FEW;
    this.legend.hidden = !rows || this.cursor.time !== null;
    drawTimeAxis(context, axis);
    const height = (axis.bottom - axis.top) / (rows ? robots.length : LANES.length);
    this.drawNames(context, axis, height, rows ? robots : null);
    drawWithin(context, axis, () => {
      robots.forEach((robot, row) => this.drawRobot(context, robot, axis, this.place(row, robots.length, height, rows)));
      drawTimes(context, axis, this.cursor.time);
    });
    this.tell();
  }

  // Returns the top of a robot's stripe for an action, its thickness, and whether it is coloured by action.
  place(row, count, height, rows) {
    if (rows) {
      const thickness = Math.max(height - 1, 1);
      return { top: () => row * height, thickness, byAction: true };
    }
    const thickness = Math.min(Math.max((height - 4) / Math.max(count, 1), 1), 5);
    const offset = 2 + (row * Math.max(height - 4 - thickness, 0)) / Math.max(count - 1, 1);
    return { top: (action) => action * height + offset, thickness, byAction: false };
  }

  drawNames(context, axis, height, robots) {
    context.textAlign = "right";
    let below = -Infinity;
    (robots ?? LANES).forEach((each, row) => {
      const y = axis.top + (row + 0.5) * height + 3.5;
      if (y - below < 9) return; // no room for its number
      below = y;
      context.fillStyle = robots ? robotColour(each.number) : colour("quiet");
      context.fillText(robots ? each.mark : each, axis.left - 6, y);
    });
  }

  drawRobot(context, robot, axis, { top, thickness, byAction }) {
    const samples = this.history.samples(robot);
    context.fillStyle = robotColour(robot.number);
    context.globalAlpha = !byAction && this.selection.id && robot.id !== this.selection.id ? 0.55 : 1;
    let at = firstInView(samples, axis.from);
    while (at < samples.length && samples[at][0] <= axis.to) {
      const [start, , , , action] = samples[at];
      let end = start;
      while (at < samples.length && samples[at][4] === action && samples[at][0] - end <= GAP) {
        end = samples[at][0];
        at += 1;
      }
      const next = at < samples.length && samples[at][0] - end <= GAP ? samples[at][0] : end + 1;
      if (action < 0) continue;
      if (byAction) context.fillStyle = colour(`action-${action}`);
      const [x0, x1] = [axis.x(start), axis.x(next)];
      context.fillRect(x0, axis.top + top(action), Math.max(x1 - x0, 1), thickness);
    }
    context.globalAlpha = 1;
  }

  tell() {
    const { time } = this.cursor;
    if (time === null) return setText(this.words, "");
    const values = this.history.at(time).slice(0, READ).map(([robot, sample]) => `${robot.label} ${actionName(this.actions[sample[4]] ?? "–")}`);
    return setText(this.words, [timeOfDay(time), ...values].join(" · "));
  }
}

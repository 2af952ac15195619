// The border unrolled from abscissa 0 to its end, coloured by the time since the last visit.

import { setText } from "./element.js";
import { duration } from "./format.js";
import { colour, idleColour, robotColour } from "./palette.js";
import { Surface } from "./surface.js";

const TOP = 9; // px for the robots' marks

export class CoverageStrip {
  constructor(canvas, words, team, site) {
    this.words = words;
    this.team = team;
    this.site = site;
    this.surface = new Surface(canvas, () => this.draw());
  }

  draw() {
    const { coverage } = this.team;
    if (!coverage || !this.surface.width) return;
    const context = this.surface.begin();
    const { width, height } = this.surface;
    const longest = Math.max(60, coverage.worst);
    const piece = width / coverage.idle.length;
    coverage.idle.forEach((idle, at) => {
      context.fillStyle = coverage.seen[at] ? idleColour(idle / longest) : colour("idle-none");
      context.fillRect(at * piece, TOP, piece + 0.6, height - TOP);
    });
    this.drawRobots(context, width);
    const seen = coverage.seen.filter(Boolean).length;
    const share = Math.round((100 * seen) / coverage.seen.length);
    setText(this.words, `average ${duration(coverage.average)} · worst ${duration(coverage.worst)} · seen ${share} %`);
  }

  drawRobots(context, width) {
    for (const robot of this.team.ordered) {
      if (!robot.decision || robot.silent(this.team.now)) continue;
      const x = (robot.decision.abscissa / this.site.border.length) * width;
      const way = robot.decision.direction > 0 ? 1 : -1;
      context.fillStyle = robotColour(robot.number);
      context.beginPath();
      context.moveTo(x - 4 * way, 0);
      context.lineTo(x + 5 * way, 4);
      context.lineTo(x - 4 * way, 8);
      context.closePath();
      context.fill();
    }
  }
}

// Names beside robots, placed so that none overprints another: shortened to the number, or moved, where it is tight.

import { colour, robotColour } from "./palette.js";

const FONT = "600 12px system-ui, 'DejaVu Sans', sans-serif";
const HEIGHT = 14; // px of a line
const BADGES = { critical: "▲ ", warning: "◆ " };
const RANK = { critical: 1, warning: 2, info: 3 };

export class MapLabels {
  constructor() {
    this.widths = new Map();
  }

  // Draws the label of each robot; taken: boxes [x0, y0, x1, y1] in px where none may be.
  draw(context, robots, viewport, { chosen, trouble, taken }) {
    context.font = FONT;
    const boxes = [...taken];
    const places = robots.map((robot) => [robot, ...viewport.toPixel(robot.pose[0], robot.pose[1])]);
    const shown = places.filter(([, px, py]) => px > -40 && py > -40 && px < viewport.width + 40 && py < viewport.height + 40);
    for (const [, px, py] of shown) boxes.push([px - 8, py - 8, px + 8, py + 8]);
    const rank = ([robot]) => (robot.id === chosen ? 0 : (RANK[trouble(robot.id)] ?? 4));
    shown.sort((a, b) => rank(a) - rank(b));
    this.last = [];
    for (const [robot, px, py] of shown) {
      const badge = BADGES[trouble(robot.id)] ?? "";
      const clear = Math.max(0.4 * viewport.scale, 14);
      this.place(context, robot, badge, [px, py], clear, boxes);
    }
  }

  place(context, robot, badge, [px, py], clear, boxes) {
    for (const words of [badge + robot.label, badge + robot.mark]) {
      const half = this.width(context, words) / 2 + 2;
      for (const [x, y] of [
        [px, py - clear - HEIGHT / 2], [px, py + clear + HEIGHT / 2], [px + clear + half, py], [px - clear - half, py],
        [px + half, py - clear - HEIGHT], [px - half, py - clear - HEIGHT],
      ]) {
        const box = [x - half, y - HEIGHT / 2, x + half, y + HEIGHT / 2];
        if (boxes.some((other) => overlap(box, other))) continue;
        boxes.push(box);
        this.write(context, robot, badge, words, x, y + 4);
        this.last.push({ id: robot.id, words, box });
        return;
      }
    }
    this.write(context, robot, "", robot.mark, px, py + 4); // on its body
    this.last.push({ id: robot.id, words: robot.mark, box: [px, py, px, py] });
  }

  write(context, robot, badge, words, x, y) {
    context.textAlign = "left";
    context.lineJoin = "round";
    context.lineWidth = 3.5;
    context.strokeStyle = colour("floor");
    const left = x - this.width(context, words) / 2;
    context.strokeText(words, left, y);
    context.fillStyle = robotColour(robot.number);
    context.fillText(words.slice(badge.length), left + (badge ? this.width(context, badge) : 0), y);
    if (!badge) return;
    context.fillStyle = colour(badge.startsWith("▲") ? "critical" : "warning");
    context.fillText(badge, left, y);
  }

  width(context, words) {
    if (!this.widths.has(words)) this.widths.set(words, context.measureText(words).width);
    return this.widths.get(words);
  }
}

function overlap(a, b) {
  return a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
}

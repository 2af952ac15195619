// The border unrolled from abscissa 0 to its end, coloured by the time since the last visit; hatched: never visited.

import { setText } from "./element.js";
import { duration } from "./format.js";
import { colour, idleColour, robotColour } from "./palette.js";
import { Surface } from "./surface.js";

const TOP = 12; // px for the robots' marks
const FOOT = 14; // px for the metres
const STEPS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const SHORTEST = 60; // s; the colours end there while nothing has been unseen for longer

export class CoverageStrip {
  // words, legend: elements beside it; go: shows an abscissa on the map.
  constructor(canvas, words, legend, { team, border, zones, go }) {
    this.canvas = canvas;
    this.words = words;
    this.team = team;
    this.border = border;
    this.zones = zones;
    this.s = null; // under the pointer, or moved by keys
    this.surface = new Surface(canvas, () => this.draw());
    this.legend = new Surface(legend, () => this.drawLegend());
    this.listen(canvas, go);
  }

  get longest() {
    return Math.max(SHORTEST, this.team.coverage?.worst ?? 0);
  }

  draw() {
    const { coverage } = this.team;
    if (!coverage || !this.surface.width) return;
    const context = this.surface.begin();
    const { width, height } = this.surface;
    const piece = width / coverage.idle.length;
    const hatch = hatching(context);
    coverage.idle.forEach((idle, at) => {
      context.fillStyle = coverage.seen[at] ? idleColour(idle / this.longest) : hatch;
      context.fillRect(at * piece, TOP, piece + 0.6, height - TOP - FOOT);
    });
    this.drawMetres(context, width, height);
    this.drawRobots(context, width);
    if (this.s !== null) this.drawCursor(context, width, height);
    this.drawLegend();
    this.tell();
  }

  drawMetres(context, width, height) {
    const step = STEPS.find((each) => (each / this.border.length) * width > 55) ?? 1000;
    context.font = "10.5px system-ui, 'DejaVu Sans', sans-serif";
    context.fillStyle = colour("quiet");
    context.strokeStyle = colour("quiet");
    context.lineWidth = 1;
    for (let s = 0; s <= this.border.length; s += step) {
      const x = Math.round((s / this.border.length) * width) + 0.5;
      context.beginPath();
      context.moveTo(x, height - FOOT);
      context.lineTo(x, height - FOOT + 3);
      context.stroke();
      context.textAlign = s === 0 ? "left" : x > width - 20 ? "right" : "center";
      context.fillText(s === 0 ? "s = 0" : `${s} m`, x, height - 2);
    }
  }

  // A triangle in the direction of travel; the number where there is room.
  drawRobots(context, width) {
    const placed = this.team.ordered.filter((robot) => robot.decision && !robot.silent(this.team.now));
    context.font = "600 9px system-ui, 'DejaVu Sans', sans-serif";
    const taken = [];
    for (const robot of placed) {
      const x = (robot.decision.abscissa / this.border.length) * width;
      const way = robot.decision.direction > 0 ? 1 : -1;
      context.fillStyle = robotColour(robot.number);
      context.beginPath();
      context.moveTo(x - 4 * way, 1);
      context.lineTo(x + 5 * way, 5.5);
      context.lineTo(x - 4 * way, 10);
      context.closePath();
      context.fill();
      if (taken.some((other) => Math.abs(other - x) < 20)) continue;
      taken.push(x);
      context.textAlign = way > 0 ? "right" : "left";
      context.fillText(robot.mark, x - 6 * way, 9);
    }
  }

  drawCursor(context, width, height) {
    const x = (this.s / this.border.length) * width;
    context.strokeStyle = colour("text");
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, 0);
    context.lineTo(x, height - FOOT + 3);
    context.stroke();
  }

  drawLegend() {
    if (!this.legend.width || !this.team.coverage) return;
    const context = this.legend.begin();
    const { width, height } = this.legend;
    const [bar, never] = [width - 60, width - 50];
    for (let x = 0; x < bar - 62; x += 1) {
      context.fillStyle = idleColour(x / (bar - 62));
      context.fillRect(30 + x, 3, 1.5, height - 6);
    }
    context.fillStyle = hatching(context);
    context.fillRect(never, 3, 14, height - 6);
    context.font = "10.5px system-ui, 'DejaVu Sans', sans-serif";
    context.fillStyle = colour("quiet");
    context.textAlign = "right";
    context.fillText("now", 27, height - 4);
    context.textAlign = "left";
    context.fillText(duration(this.longest), bar - 29, height - 4);
    context.fillText("never", never + 17, height - 4);
  }

  // Tells the place at the cursor, else the whole border.
  tell() {
    const { coverage } = this.team;
    const seen = coverage.seen.filter(Boolean).length;
    const share = Math.round((100 * seen) / coverage.seen.length);
    const all = `average ${duration(coverage.average)} · worst ${duration(coverage.worst)} · seen ${share} %`;
    setText(this.words, this.s === null ? all : this.placeWords());
    this.canvas.setAttribute("aria-valuenow", (this.s ?? 0).toFixed(1));
    this.canvas.setAttribute("aria-valuemax", this.border.length.toFixed(1));
    this.canvas.setAttribute("aria-valuetext", this.s === null ? all : this.placeWords());
  }

  placeWords() {
    const { idle, seen } = this.team.coverage;
    const at = Math.min(Math.floor((this.s / this.border.length) * idle.length), idle.length - 1);
    const zone = this.zones.nameAt(...this.border.at(this.s));
    const visit = seen[at] ? `visited ${duration(idle[at])} ago` : "never visited";
    return `s = ${this.s.toFixed(1)} m${zone ? ` (${zone})` : ""}: ${visit}`;
  }

  listen(canvas, go) {
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      return (Math.min(Math.max(event.clientX - box.left, 0), box.width) / box.width) * this.border.length;
    };
    canvas.addEventListener("pointermove", (event) => this.set(at(event)));
    canvas.addEventListener("pointerleave", () => this.set(null));
    canvas.addEventListener("blur", () => this.set(null));
    canvas.addEventListener("click", (event) => go(at(event)));
    canvas.addEventListener("keydown", (event) => {
      const s = this.s ?? 0;
      const moves = { ArrowLeft: s - 1, ArrowDown: s - 1, ArrowRight: s + 1, ArrowUp: s + 1, PageUp: s + 10, PageDown: s - 10, Home: 0, End: this.border.length };
      if (event.key in moves) this.set(Math.min(Math.max(moves[event.key], 0), this.border.length));
      else if (event.key === "Enter") go(s);
      else return;
      event.preventDefault();
    });
  }

  set(s) {
    this.s = s;
    this.draw();
  }
}

// Diagonal lines: told from every colour of a visit without colour.
function hatching(context) {
  const tile = document.createElement("canvas");
  tile.width = tile.height = 6;
  const pattern = tile.getContext("2d");
  pattern.fillStyle = colour("panel");
  pattern.fillRect(0, 0, 6, 6);
  pattern.strokeStyle = colour("quiet");
  pattern.lineWidth = 1.2;
  for (const x of [-6, 0, 6]) {
    pattern.moveTo(x, 6);
    pattern.lineTo(x + 6, 0);
  }
  pattern.stroke();
  return context.createPattern(tile, "repeat");
}

// Measuring on the map: points by clicks, or by Enter in the middle of the view; lengths beside the lines.

import { colour } from "./palette.js";

export class Measure {
  constructor() {
    this.on = false;
    this.points = [];
  }

  toggle() {
    this.on = !this.on;
    this.points = [];
  }

  add(x, y) {
    this.points.push([x, y]);
  }

  get total() {
    return this.lengths().reduce((sum, length) => sum + length, 0);
  }

  lengths() {
    return this.points.slice(1).map(([x, y], at) => Math.hypot(x - this.points[at][0], y - this.points[at][1]));
  }

  words() {
    if (!this.on) return "";
    if (this.points.length < 2) return "click two places, or press Enter on the map";
    return `measured ${this.total.toFixed(2)} m`;
  }

  // The context is in pixels.
  draw(context, viewport) {
    if (!this.on) return;
    const pixels = this.points.map(([x, y]) => viewport.toPixel(x, y));
    for (const [style, width] of [["floor", 5], ["accent", 2]]) {
      context.strokeStyle = colour(style);
      context.lineWidth = width;
      context.beginPath();
      for (const [x, y] of pixels) context.lineTo(x, y);
      context.stroke();
    }
    context.fillStyle = colour("accent");
    for (const [x, y] of pixels) {
      context.beginPath();
      context.arc(x, y, 3.5, 0, 2 * Math.PI);
      context.fill();
    }
    this.drawLengths(context, pixels);
    const [x, y] = [viewport.width / 2, viewport.height / 2];
    context.lineWidth = 1;
    context.strokeStyle = colour("accent");
    context.beginPath();
    context.moveTo(x - 6, y);
    context.lineTo(x + 6, y);
    context.moveTo(x, y - 6);
    context.lineTo(x, y + 6);
    context.stroke();
  }

  drawLengths(context, pixels) {
    context.font = "600 12px system-ui, 'DejaVu Sans', sans-serif";
    context.textAlign = "center";
    context.lineWidth = 3.5;
    context.strokeStyle = colour("floor");
    this.lengths().forEach((length, at) => {
      const [x, y] = [(pixels[at][0] + pixels[at + 1][0]) / 2, (pixels[at][1] + pixels[at + 1][1]) / 2 - 6];
      context.strokeText(`${length.toFixed(2)} m`, x, y);
      context.fillText(`${length.toFixed(2)} m`, x, y);
    });
  }
}

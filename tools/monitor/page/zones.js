// The named zones of the map: which one a place lies in, and their drawing.

import { colour } from "./palette.js";

const SMALLEST = 40; // px across a zone from which its name is shown

export class Zones {
  constructor(zones = []) {
    this.zones = zones;
  }

  // Returns the name of the first zone that holds a place, m; empty if none does.
  nameAt(x, y) {
    return this.zones.find(({ polygon }) => contains(polygon, x, y))?.name ?? "";
  }

  // The context is in metres.
  drawAreas(context, scale) {
    context.lineWidth = 1 / scale;
    context.strokeStyle = context.fillStyle = colour("zone");
    context.setLineDash([3 / scale, 3 / scale]);
    for (const { polygon } of this.zones) {
      context.beginPath();
      for (const [x, y] of polygon) context.lineTo(x, y);
      context.closePath();
      context.globalAlpha = 0.07;
      context.fill();
      context.globalAlpha = 0.7;
      context.stroke();
    }
    context.globalAlpha = 1;
    context.setLineDash([]);
  }

  // The context is in pixels.
  drawNames(context, viewport) {
    context.font = "11px system-ui, 'DejaVu Sans', sans-serif";
    context.textAlign = "center";
    context.lineJoin = "round";
    context.lineWidth = 3;
    context.strokeStyle = colour("floor");
    context.fillStyle = colour("zone");
    for (const { name, polygon } of this.zones) {
      const pixels = polygon.map(([x, y]) => viewport.toPixel(x, y));
      const [xs, ys] = [pixels.map((p) => p[0]), pixels.map((p) => p[1])];
      if (Math.max(...xs) - Math.min(...xs) < SMALLEST && Math.max(...ys) - Math.min(...ys) < SMALLEST) continue;
      const [px, py] = viewport.toPixel(...middle(polygon));
      context.strokeText(name, px, py + 4);
      context.fillText(name, px, py + 4);
    }
  }
}

function contains(polygon, x, y) {
  let inside = false;
  let [ax, ay] = polygon[polygon.length - 1];
  for (const [bx, by] of polygon) {
    if (ay > y !== by > y && x < ax + ((bx - ax) * (y - ay)) / (by - ay)) inside = !inside;
    [ax, ay] = [bx, by];
  }
  return inside;
}

// The centre of area, or the middle of the first side where that lies outside.
function middle(polygon) {
  let [area, cx, cy] = [0, 0, 0];
  polygon.forEach(([ax, ay], at) => {
    const [bx, by] = polygon[(at + 1) % polygon.length];
    const cross = ax * by - bx * ay;
    area += cross / 2;
    cx += ((ax + bx) * cross) / 6;
    cy += ((ay + by) * cross) / 6;
  });
  const [x, y] = [cx / area, cy / area];
  if (contains(polygon, x, y)) return [x, y];
  const [[ax, ay], [bx, by]] = polygon;
  return [(ax + bx) / 2, (ay + by) / 2];
}

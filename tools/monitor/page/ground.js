// The static part of the map: walls, grid and border, painted once per theme and view.

import { colour, idleColour, parts } from "./palette.js";
import { Zones } from "./zones.js";

const FREE = 0;
const UNKNOWN = 128;

export class Ground {
  constructor(site, onReady) {
    this.site = site;
    this.zones = new Zones(site.zones);
    this.cells = null;
    this.picture = null;
    if (site.map) this.load(onReady);
  }

  async load(onReady) {
    const image = new Image();
    image.src = "/map.png";
    await image.decode();
    const canvas = document.createElement("canvas");
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    this.cells = context.getImageData(0, 0, image.width, image.height);
    this.paint();
    onReady();
  }

  // Colours the cells for the present theme.
  paint() {
    if (!this.cells) return;
    const { width, height, data } = this.cells;
    const [floor, unknown, wall] = [parts("floor"), parts("unknown"), parts("wall")];
    const image = new ImageData(width, height);
    for (let at = 0; at < data.length; at += 4) {
      const [r, g, b] = data[at] === FREE ? floor : data[at] === UNKNOWN ? unknown : wall;
      image.data[at] = r;
      image.data[at + 1] = g;
      image.data[at + 2] = b;
      image.data[at + 3] = 255;
    }
    this.picture = document.createElement("canvas");
    this.picture.width = width;
    this.picture.height = height;
    this.picture.getContext("2d").putImageData(image, 0, 0);
  }

  // Returns x0, y0, x1, y1 of map and border, or of the robots without a map, m.
  bounds(robots) {
    const points = [...(this.site.border?.points ?? [])];
    if (this.site.map) {
      const { x, y, columns, rows, resolution } = this.site.map;
      points.push([x, y], [x + columns * resolution, y + rows * resolution]);
    }
    if (!points.length) for (const robot of robots) if (robot.pose) points.push(robot.pose);
    if (!points.length) return [-5, -5, 5, 5];
    const [xs, ys] = [points.map((p) => p[0]), points.map((p) => p[1])];
    return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
  }

  draw(context, viewport, layers, coverage) {
    if (this.picture && layers.map) this.drawMap(context, viewport);
    if (layers.zones) this.zones.drawAreas(context, viewport.scale);
    if (layers.grid || !this.site.map) this.drawGrid(context, viewport);
    if (this.site.border && layers.border) this.drawBorder(context, viewport, layers.idleness ? coverage : null);
  }

  drawMap(context, viewport) {
    const { x, y, columns, rows, resolution } = this.site.map;
    context.save();
    context.translate(x, y + rows * resolution);
    context.scale(resolution, -resolution);
    context.imageSmoothingEnabled = viewport.scale * resolution < 1;
    context.drawImage(this.picture, 0, 0, columns, rows);
    context.restore();
  }

  // The coordinates of the grid's lines at the left and lower edges; the context is in pixels.
  drawGridNumbers(context, viewport) {
    const step = gridStep(viewport);
    const [left, top] = viewport.toMap(0, 0);
    const [right, bottom] = viewport.toMap(viewport.width, viewport.height);
    context.font = "10.5px system-ui, 'DejaVu Sans', sans-serif";
    context.fillStyle = colour("quiet");
    context.textAlign = "left";
    for (let x = Math.ceil(left / step) * step; x < right; x += step) {
      context.fillText(`${x}`, viewport.toPixel(x, 0)[0] + 3, viewport.height - 4);
    }
    for (let y = Math.ceil(bottom / step) * step; y < top; y += step) {
      context.fillText(`${y}`, 3, viewport.toPixel(0, y)[1] - 3);
    }
  }

  drawGrid(context, viewport) {
    const step = gridStep(viewport);
    const [left, top] = viewport.toMap(0, 0);
    const [right, bottom] = viewport.toMap(viewport.width, viewport.height);
    context.beginPath();
    for (let x = Math.ceil(left / step) * step; x < right; x += step) {
      context.moveTo(x, bottom);
      context.lineTo(x, top);
    }
    for (let y = Math.ceil(bottom / step) * step; y < top; y += step) {
      context.moveTo(left, y);
      context.lineTo(right, y);
    }
    context.strokeStyle = colour("line");
    context.lineWidth = 1 / viewport.scale;
    context.stroke();
  }

  drawBorder(context, viewport, coverage) {
    const { points } = this.site.border;
    const line = (from, to) => {
      context.beginPath();
      for (let at = from; at <= to; at += 1) context.lineTo(points[at][0], points[at][1]);
      context.stroke();
    };
    context.lineJoin = "round";
    if (coverage) {
      const longest = Math.max(60, coverage.worst);
      const pieces = coverage.idle.length - 1;
      context.lineWidth = 7 / viewport.scale;
      context.globalAlpha = 0.55;
      for (let piece = 0; piece < pieces; piece += 1) {
        context.strokeStyle = coverage.seen[piece] ? idleColour(coverage.idle[piece] / longest) : colour("idle-none");
        const last = points.length - 1;
        line(Math.floor((piece * last) / pieces), Math.ceil(((piece + 1) * last) / pieces));
      }
      context.globalAlpha = 1;
    }
    context.strokeStyle = colour("border-line");
    context.lineWidth = 1.5 / viewport.scale;
    context.setLineDash([6 / viewport.scale, 4 / viewport.scale]);
    line(0, points.length - 1);
    context.setLineDash([]);
  }
}

// m between two lines of the grid.
function gridStep(viewport) {
  return viewport.scale > 60 ? 1 : viewport.scale > 12 ? 5 : 10;
}

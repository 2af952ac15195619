// Draws map, zones, border and corners.

export class Drawing {
  constructor(canvas, view) {
    this.canvas = canvas;
    this.view = view;
    this.ground = null; // the map, recoloured
  }

  setMap(image, map) {
    this.map = map;
    this.image = image;
    this.recolour();
  }

  recolour() {
    const style = getComputedStyle(document.documentElement);
    this.colour = (name) => style.getPropertyValue(`--${name}`).trim();
    const ground = document.createElement("canvas");
    [ground.width, ground.height] = [this.image.width, this.image.height];
    const context = ground.getContext("2d");
    context.drawImage(this.image, 0, 0);
    const pixels = context.getImageData(0, 0, ground.width, ground.height);
    const tones = { 0: rgb(this.colour("free")), 128: rgb(this.colour("unknown")), 255: rgb(this.colour("wall")) };
    for (let k = 0; k < pixels.data.length; k += 4) {
      const tone = tones[pixels.data[k]] ?? tones[128];
      [pixels.data[k], pixels.data[k + 1], pixels.data[k + 2]] = tone;
    }
    context.putImageData(pixels, 0, 0);
    this.ground = ground;
  }

  draw(draft, judgement, zones) {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth, clientHeight } = this.canvas;
    [this.canvas.width, this.canvas.height] = [clientWidth * ratio, clientHeight * ratio];
    this.view.resize(clientWidth, clientHeight);
    const context = this.canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = this.colour("unknown");
    context.fillRect(0, 0, clientWidth, clientHeight);
    this.#drawMap(context);
    this.#drawZones(context, zones);
    this.#drawLines(context, draft);
    for (const stretch of judgement?.line ?? []) this.#drawStretch(context, stretch);
    this.#drawCorners(context, draft);
  }

  #drawMap(context) {
    const { x, y, resolution, columns, rows } = this.map;
    const [left, top] = this.view.toPixel(x, y + rows * resolution);
    const [right, bottom] = this.view.toPixel(x + columns * resolution, y);
    context.imageSmoothingEnabled = false;
    context.drawImage(this.ground, left, top, right - left, bottom - top);
  }

  // The one being drawn last, with its corners.
  #drawZones(context, { zones, corners }) {
    context.strokeStyle = context.fillStyle = this.colour("main");
    context.font = "12px system-ui, sans-serif";
    for (const { name, polygon } of zones) {
      context.globalAlpha = 0.12;
      this.#line(context, polygon);
      context.fill();
      context.globalAlpha = 0.8;
      this.#line(context, [...polygon, polygon[0]]);
      context.globalAlpha = 1;
      const [x, y] = this.view.toPixel(...polygon[0]);
      context.fillText(name, x + 5, y - 5);
    }
    this.#line(context, corners ?? []);
    for (const corner of corners ?? []) context.fillRect(...this.view.toPixel(...corner).map((at) => at - 3), 6, 6);
  }

  #drawLines(context, draft) {
    context.strokeStyle = this.colour("quiet");
    context.lineWidth = 1;
    context.setLineDash([5, 5]);
    for (const [a, b] of draft.lines()) this.#line(context, [[a.x, a.y], [b.x, b.y]]);
    context.setLineDash([]);
  }

  #drawStretch(context, { ok, points }) {
    context.strokeStyle = this.colour(ok ? "good" : "bad");
    context.lineWidth = 3;
    this.#line(context, points);
  }

  #drawCorners(context, draft) {
    draft.vertices.forEach((corner, index) => {
      const [px, py] = this.view.toPixel(corner.x, corner.y);
      const chosen = index === draft.chosen;
      context.fillStyle = this.colour(chosen ? "main" : "card");
      context.strokeStyle = this.colour("main");
      context.lineWidth = 2;
      context.fillRect(px - 5, py - 5, 10, 10);
      context.strokeRect(px - 5, py - 5, 10, 10);
      const handle = chosen ? draft.handle(index) : null;
      if (!handle) return;
      context.beginPath();
      context.arc(...this.view.toPixel(handle.x, handle.y), 5, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    });
  }

  #line(context, points) {
    context.beginPath();
    for (const [x, y] of points) context.lineTo(...this.view.toPixel(x, y));
    context.stroke();
  }
}

function rgb(hex) {
  const long = hex.length === 4 ? [...hex.slice(1)].map((digit) => digit + digit).join("") : hex.slice(1);
  return [0, 2, 4].map((place) => parseInt(long.slice(place, place + 2), 16));
}

// The visible part of the map: conversion of metres to pixels and back, zoom, pan.

const CLOSEST = 400; // px per m
const WIDEST = 2;

export class Viewport {
  constructor() {
    this.x = 0; // map point in the middle, m
    this.y = 0;
    this.scale = 20; // px per m
    this.width = 1;
    this.height = 1;
    this.touched = false; // zoomed or panned; until then every resize fits the map again
  }

  resize(width, height) {
    this.width = width;
    this.height = height;
  }

  fit(bounds, margin = 26) {
    const [x0, y0, x1, y1] = bounds;
    this.x = (x0 + x1) / 2;
    this.y = (y0 + y1) / 2;
    const across = (this.width - 2 * margin) / Math.max(x1 - x0, 1);
    const up = (this.height - 2 * margin) / Math.max(y1 - y0, 1);
    this.scale = Math.min(Math.max(Math.min(across, up), WIDEST), CLOSEST);
    this.touched = false;
  }

  // Zooms by a factor; the map point under pixel (px, py) stays in place.
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.toMap(px, py);
    this.scale = Math.min(Math.max(this.scale * factor, WIDEST), CLOSEST);
    this.x = x - (px - this.width / 2) / this.scale;
    this.y = y + (py - this.height / 2) / this.scale;
    this.touched = true;
  }

  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
    this.touched = true;
  }

  toMap(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  toPixel(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  // Sets the context's transform to map metres, y up.
  apply(context, ratio) {
    const s = this.scale * ratio;
    context.setTransform(
      s, 0, 0, -s, ratio * (this.width / 2 - this.x * this.scale), ratio * (this.height / 2 + this.y * this.scale),
    );
  }
}

// The map: redrawn on changes; zoom, pan, follow, selection of a robot.

import { colour } from "./palette.js";
import { Ground } from "./ground.js";
import { IntruderMarks } from "./intruder_marks.js";
import { MapLabels } from "./map_labels.js";
import { Measure } from "./measure.js";
import {
  drawBody, drawCovariance, drawParticles, drawScan, drawTracks, drawTrail, drawVisibility,
} from "./robot_drawing.js";
import { Surface } from "./surface.js";
import { Viewport } from "./viewport.js";

const PAN_STEP = 60; // px per key press
const PICK_RADIUS = 26; // px

export class MapView {
  // onPlace: called with the place under the pointer, m; null when it leaves.
  constructor(canvas, site, team, layers, selection, onPlace) {
    this.onPlace = onPlace;
    this.measure = new Measure();
    this.place = null; // shown with a mark, m
    this.site = site;
    this.team = team;
    this.layers = layers;
    this.selection = selection;
    this.following = false;
    this.changed = true;
    this.labels = new MapLabels();
    this.intruders = new IntruderMarks(() => this.refresh());
    this.viewport = new Viewport();
    this.still = document.createElement("canvas");
    this.stillKey = "";
    this.ground = new Ground(site, () => this.refresh());
    this.surface = new Surface(canvas, () => this.resize());
    this.resize();
    this.listen(canvas);
  }

  refresh() {
    this.stillKey = "";
    this.changed = true;
  }

  restyle() {
    this.ground.paint();
    this.refresh();
  }

  resize() {
    this.viewport.resize(this.surface.width, this.surface.height);
    if (!this.viewport.touched) this.fit();
    this.refresh();
  }

  fit() {
    this.viewport.fit(this.ground.bounds(this.team.ordered));
    this.changed = true;
  }

  // Brings a place to the middle and marks it.
  show(place) {
    this.place = place;
    this.centre(place);
  }

  // Brings a pose to the middle; nothing without one.
  centre(pose) {
    if (!pose) return;
    [this.viewport.x, this.viewport.y] = pose;
    this.viewport.touched = true;
    this.refresh();
  }

  zoom(factor, px, py) {
    this.viewport.zoom(factor, px, py);
    this.changed = true;
  }

  pan(dx, dy) {
    this.viewport.pan(dx, dy);
    this.changed = true;
  }

  follow(wanted) {
    this.following = wanted;
    if (wanted && this.viewport.scale < 40) this.viewport.zoom(40 / this.viewport.scale);
    this.changed = true;
  }

  // Draws if anything has changed; returns whether it drew.
  draw() {
    if (!this.changed || !this.surface.width) return false;
    this.changed = false;
    const { context, ratio } = this.surface;
    const { viewport, site, layers, team } = this;
    const chosen = team.robots.get(this.selection.id);
    if (this.following && chosen?.pose) [viewport.x, viewport.y] = chosen.pose;
    this.drawGround(context, ratio);
    viewport.apply(context, ratio);
    const placed = team.ordered.filter((robot) => robot.pose);
    const each = (layer, paint) => layers[layer] && placed.forEach(paint);
    const { scale } = viewport;
    const worst = team.troubles();
    const trouble = (id) => worst.get(id) ?? "";
    each("trail", (robot) => drawTrail(context, robot, scale));
    each("visibility", (robot) => drawVisibility(context, robot, site, scale));
    each("scan", (robot) => drawScan(context, robot, site, scale, team.now));
    each("tracks", (robot) => drawTracks(context, robot, scale, team.now));
    for (const robot of placed) {
      const looks = { chosen: robot === chosen, silent: robot.silent(team.now), trouble: trouble(robot.id) };
      drawBody(context, robot, site, scale, looks);
    }
    each("particles", (robot) => drawParticles(context, robot, scale));
    each("covariance", (robot) => drawCovariance(context, robot, scale));
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const sightings = layers.tracks ? team.alarms.filter((alarm) => alarm.seen !== null) : [];
    const taken = sightings.map((alarm) => this.intruders.box(alarm, viewport));
    if (layers.names) this.labels.draw(context, placed, viewport, { chosen: chosen?.id, trouble, taken });
    for (const alarm of sightings) this.intruders.draw(context, alarm, viewport, team.wall);
    this.measure.draw(context, viewport);
    if (this.place) drawPlace(context, viewport.toPixel(...this.place));
    this.drawScale(context);
    return true;
  }

  // Walls and border change only with the view: they are cached as a picture.
  drawGround(context, ratio) {
    const { viewport, layers } = this;
    const { width, height } = this.surface.canvas;
    const covered = layers.idleness ? Math.floor(this.team.now / 2) : 0;
    const key = [width, height, viewport.x, viewport.y, viewport.scale, covered, layers.map, layers.border, layers.grid, layers.zones, layers.idleness].join();
    if (key !== this.stillKey) {
      this.stillKey = key;
      this.still.width = width;
      this.still.height = height;
      const still = this.still.getContext("2d");
      still.fillStyle = colour("unknown");
      still.fillRect(0, 0, width, height);
      viewport.apply(still, ratio);
      this.ground.draw(still, viewport, layers, this.team.coverage);
      still.setTransform(ratio, 0, 0, ratio, 0, 0);
      if (layers.zones) this.ground.zones.drawNames(still, viewport);
      if (layers.grid || !this.site.map) this.ground.drawGridNumbers(still, viewport);
    }
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(this.still, 0, 0);
  }

  drawScale(context) {
    const { width: across, height } = this.surface;
    const metres = [0.5, 1, 2, 5, 10, 20, 50].find((length) => length * this.viewport.scale > 60) ?? 50;
    const [right, y] = [across - 16, height - 14];
    const left = right - metres * this.viewport.scale;
    context.font = "11px system-ui, 'DejaVu Sans', sans-serif";
    context.textAlign = "center";
    // First wide in the background's colour, then thin: readable over walls as well.
    for (const [style, width] of [["unknown", 5], ["quiet", 1.5]]) {
      context.strokeStyle = colour(style);
      context.lineWidth = width;
      context.beginPath();
      context.moveTo(left, y - 4);
      context.lineTo(left, y);
      context.lineTo(right, y);
      context.lineTo(right, y - 4);
      context.stroke();
      if (style === "unknown") context.strokeText(`${metres} m`, (left + right) / 2, y - 6);
    }
    context.fillStyle = colour("quiet");
    context.fillText(`${metres} m`, (left + right) / 2, y - 6);
  }

  listen(canvas) {
    const pointers = new Map();
    let moved = 0;
    const place = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, place(event));
      moved = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      this.onPlace(this.viewport.toMap(...place(event)));
      if (!before) return;
      const now = place(event);
      moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
      if (pointers.size === 2) this.pinch([...pointers.entries()], event.pointerId, now);
      else if (moved > 4) this.drag(now[0] - before[0], now[1] - before[1]);
      pointers.set(event.pointerId, now);
    });
    const release = (event) => {
      if (pointers.delete(event.pointerId) && moved <= 4 && event.type === "pointerup") this.pick(...place(event));
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointerleave", () => this.onPlace(null));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * 0.0015), ...place(event));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  drag(dx, dy) {
    this.selection.stopFollowing();
    this.pan(dx, dy);
  }

  pinch(pointers, id, now) {
    const [other] = pointers.filter(([key]) => key !== id).map(([, at]) => at);
    const [before] = pointers.filter(([key]) => key === id).map(([, at]) => at);
    const far = (a, b) => Math.max(Math.hypot(a[0] - b[0], a[1] - b[1]), 1);
    this.zoom(far(now, other) / far(before, other), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  }

  pick(px, py) {
    this.place = null;
    this.changed = true;
    if (this.measure.on) {
      this.measure.add(...this.viewport.toMap(px, py));
      this.onPlace(this.viewport.toMap(px, py));
      return;
    }
    let [best, nearest] = [null, PICK_RADIUS];
    for (const robot of this.team.ordered) {
      if (!robot.pose) continue;
      const [x, y] = this.viewport.toPixel(robot.pose[0], robot.pose[1]);
      const distance = Math.hypot(x - px, y - py);
      if (distance < nearest) [best, nearest] = [robot, distance];
    }
    if (best) this.selection.choose(best.id);
  }

  toggleMeasure() {
    this.measure.toggle();
    this.changed = true;
  }

  key(event) {
    if (event.key === "Enter" && this.measure.on) {
      event.preventDefault();
      this.pick(this.viewport.width / 2, this.viewport.height / 2);
    }
    const steps = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const step = steps[event.key];
    if (!step) return;
    event.preventDefault();
    this.drag(step[0] * PAN_STEP, step[1] * PAN_STEP);
  }
}

function drawPlace(context, [px, py]) {
  for (const [style, width] of [["floor", 6], ["accent", 2.5]]) {
    context.strokeStyle = colour(style);
    context.lineWidth = width;
    context.beginPath();
    context.arc(px, py, 11, 0, 2 * Math.PI);
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      context.moveTo(px + 7 * dx, py + 7 * dy);
      context.lineTo(px + 17 * dx, py + 17 * dy);
    }
    context.stroke();
  }
}

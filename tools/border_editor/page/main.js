// The editor: pointer and keys change the draft, the server judges it, the drawing shows both.

import { Draft } from "./draft.js";
import { Drawing } from "./drawing.js";
import { ask, site } from "./server.js";
import { Viewport } from "./viewport.js";
import { ZonePanel } from "./zone_panel.js";

const NEAR = 10; // px from the pointer to a corner, a handle or the line
const element = (id) => document.getElementById(id);
const metres = (value) => (value === null ? "–" : `${value.toFixed(2)} m`);

const canvas = element("map");
const view = new Viewport();
const drawing = new Drawing(canvas, view);
let draft;
let judgement = null;
let asked = 0; // number of the last judgement asked for
let drag = null; // what the pointer holds
let saved = "";
let zones; // the panel of the zones
let savedZones = "";

async function start() {
  const { name, file, map, draft: content, zones: named, trouble } = await site();
  element("name").textContent = name;
  element("saved").textContent = trouble || file;
  draft = new Draft(content);
  saved = JSON.stringify(content);
  savedZones = JSON.stringify(named);
  zones = new ZonePanel(named, { button: element("zone"), list: element("zones") }, redraw);
  const image = new Image();
  image.src = "/map.png";
  await image.decode();
  drawing.setMap(image, map);
  redraw();
  fit();
  changed();
  window.editor = { draft, view, zones, get judgement() { return judgement; } };
}

function fit() {
  const { x, y, resolution, columns, rows } = drawing.map;
  view.fit([x, y, x + columns * resolution, y + rows * resolution]);
  redraw();
}

function redraw() {
  if (drawing.ground) drawing.draw(draft, judgement, zones);
}

// Shows the draft and asks for its judgement; an answer that a later change has overtaken is dropped.
async function changed() {
  const number = (asked += 1);
  showSettings();
  redraw();
  const answer = await ask("judge", draft.content);
  if (number !== asked) return;
  judgement = answer;
  showJudgement();
  redraw();
}

function showSettings() {
  element("closed").checked = draft.content.closed;
  element("radius").value = draft.content.corner_radius;
  element("undo").disabled = !draft.before.length;
  const own = draft.chosen >= 0;
  element("own").hidden = !own;
  if (own) element("own-radius").value = draft.radiusOf(draft.chosen);
}

function showJudgement() {
  const { ok, error, faults, length, clearance, radius, robots } = judgement;
  const verdict = element("verdict");
  verdict.dataset.ok = ok;
  verdict.textContent = ok ? "robots can patrol it" : error || `${faults.length} to mend`;
  element("length").textContent = metres(length);
  element("clearance").textContent = metres(clearance);
  element("turn").textContent = metres(radius);
  element("robots").textContent = robots ? `${robots} robots` : "–";
  element("faults").replaceChildren(...faults.map((fault) => {
    const item = document.createElement("li");
    item.textContent = fault;
    return item;
  }));
}

// --- pointer -------------------------------------------------------------------------------------

const pixel = (event) => [event.offsetX, event.offsetY];
const isNear = (place, [px, py]) => {
  const [x, y] = view.toPixel(place.x, place.y);
  return Math.hypot(x - px, y - py) <= NEAR;
};

function cornerAt(at) {
  return draft.vertices.findIndex((corner) => isNear(corner, at));
}

// The index at which a corner on the line under the pointer belongs; -1 off the line.
function lineAt([px, py]) {
  for (const [a, b, index] of draft.lines()) {
    const [ax, ay] = view.toPixel(a.x, a.y);
    const [bx, by] = view.toPixel(b.x, b.y);
    const [dx, dy] = [bx - ax, by - ay];
    const along = Math.min(1, Math.max(0, ((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy || 1)));
    if (Math.hypot(ax + along * dx - px, ay + along * dy - py) <= NEAR / 2) return index;
  }
  return -1;
}

function pressed(event) {
  canvas.focus();
  canvas.setPointerCapture(event.pointerId);
  const at = pixel(event);
  if (zones.drawing) {
    drag = { kind: "floor", at, moved: false };
    return;
  }
  if (event.button === 2) {
    draft.remove(cornerAt(at));
    changed();
    return;
  }
  const handle = draft.chosen >= 0 ? draft.handle(draft.chosen) : null;
  if (handle && isNear(handle, at)) drag = { kind: "radius", moved: false };
  else if ((draft.chosen = cornerAt(at)) >= 0) drag = { kind: "corner", moved: false };
  else drag = { kind: "floor", at, moved: false };
  showSettings();
  redraw();
}

function moved(event) {
  const [px, py] = pixel(event);
  const [x, y] = view.toMap(px, py);
  element("place").textContent = `x ${x.toFixed(2)} m, y ${y.toFixed(2)} m`;
  if (!drag) return;
  if (!drag.moved && drag.kind !== "floor") draft.remember();
  if (drag.kind === "floor") {
    if (!drag.moved && Math.hypot(px - drag.at[0], py - drag.at[1]) < 4) return;
    view.pan(event.movementX, event.movementY);
    redraw();
  } else {
    const corner = draft.vertices[draft.chosen];
    if (drag.kind === "corner") [corner.x, corner.y] = [x, y];
    else corner.radius = draft.radiusFor(draft.chosen, Math.hypot(x - corner.x, y - corner.y));
    changed();
  }
  drag.moved = true;
}

async function released(event) {
  if (!drag) return;
  const { kind, moved: hasMoved } = drag;
  drag = null;
  const at = pixel(event);
  if (zones.drawing) {
    if (!hasMoved) zones.add(...view.toMap(...at));
  } else if (kind === "floor" && !hasMoved) {
    const between = lineAt(at);
    draft.remember();
    draft.insert(between < 0 ? draft.vertices.length : between, ...view.toMap(...at));
    await snapped();
  } else if (kind === "corner" && hasMoved) {
    await snapped();
  }
}

// Puts the chosen corner where there is room, if that is wanted.
async function snapped() {
  const corner = draft.vertices[draft.chosen];
  if (element("snapping").checked) {
    const { x, y } = await ask("snap", { x: corner.x, y: corner.y });
    [corner.x, corner.y] = [x, y];
  }
  changed();
}

canvas.addEventListener("pointerdown", pressed);
canvas.addEventListener("pointermove", moved);
canvas.addEventListener("pointerup", released);
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  view.zoom(event.deltaY < 0 ? 1.2 : 1 / 1.2, ...pixel(event));
  redraw();
}, { passive: false });

// --- buttons and keys ----------------------------------------------------------------------------

async function suggest() {
  element("saved").textContent = "looking for a loop …";
  const found = await ask("suggest");
  element("saved").textContent = found
    ? "a loop along the middle of the corridors: change it as you like, then save"
    : "no loop with enough room on this map: draw an open border, or one by hand";
  if (found) draft.replace(found);
  changed();
}

// Saves the border, unless it is as it was and zones are not.
async function save() {
  const told = [];
  const zonesChanged = JSON.stringify(zones.zones) !== savedZones;
  if (!zonesChanged || JSON.stringify(draft.content) !== saved) {
    const { saved: done, why } = await ask("save", draft.content);
    if (done) saved = JSON.stringify(draft.content);
    told.push(done ? "saved" : `not saved: ${why}`);
  }
  if (zonesChanged) {
    const { saved: done, why } = await ask("zones", { zone: zones.zones });
    if (done) savedZones = JSON.stringify(zones.zones);
    told.push(done ? "zones saved" : `zones not saved: ${why}`);
  }
  element("saved").textContent = told.join("; ");
}

function change(apply) {
  draft.remember();
  apply();
  changed();
}

function undo() {
  draft.undo();
  changed();
}

element("suggest").addEventListener("click", suggest);
element("save").addEventListener("click", save);
element("undo").addEventListener("click", undo);
element("clear").addEventListener("click", () => change(() => { draft.vertices.length = 0; draft.chosen = -1; }));
element("fit").addEventListener("click", fit);
element("closed").addEventListener("change", (event) => change(() => { draft.content.closed = event.target.checked; }));
element("radius").addEventListener("change", (event) => {
  if (event.target.valueAsNumber > 0) change(() => { draft.content.corner_radius = event.target.valueAsNumber; });
});
element("own-radius").addEventListener("change", (event) => {
  if (event.target.valueAsNumber > 0) change(() => { draft.vertices[draft.chosen].radius = event.target.valueAsNumber; });
});
element("remove").addEventListener("click", () => { draft.remove(draft.chosen); changed(); });
window.addEventListener("keydown", (event) => {
  if (event.target instanceof HTMLInputElement) return;
  if (zones.drawing) {
    const acts = { Enter: () => zones.finish(), Escape: () => zones.cancel(), Backspace: () => zones.removeLast() };
    if (event.key in acts && !(event.target instanceof HTMLButtonElement)) acts[event.key]();
    return;
  }
  if (event.key === "Delete" || event.key === "Backspace") { draft.remove(draft.chosen); changed(); }
  else if (event.key === "z" && event.ctrlKey) undo();
  else if (event.key === "0") fit();
});
window.addEventListener("resize", redraw);
window.addEventListener("beforeunload", (event) => {
  const border = draft && JSON.stringify(draft.content) !== saved;
  if (border || (zones && JSON.stringify(zones.zones) !== savedZones)) event.preventDefault();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { drawing.recolour(); redraw(); });

start();

// The border being drawn: corners, closed or open, radii; with undo.

const MOST_UNDONE = 200;

export class Draft {
  constructor(content) {
    this.content = content;
    this.before = [];
    this.chosen = -1; // index of the chosen corner
  }

  get vertices() {
    return this.content.vertices;
  }

  // Keeps the present content for undo; call before a change.
  remember() {
    this.before.push(JSON.stringify(this.content));
    if (this.before.length > MOST_UNDONE) this.before.shift();
  }

  undo() {
    if (!this.before.length) return;
    this.content = JSON.parse(this.before.pop());
    this.chosen = -1;
  }

  replace(content) {
    this.remember();
    this.content = content;
    this.chosen = -1;
  }

  insert(index, x, y) {
    this.vertices.splice(index, 0, { x, y, radius: null });
    this.chosen = index;
  }

  remove(index) {
    if (index < 0) return;
    this.remember();
    this.vertices.splice(index, 1);
    this.chosen = -1;
  }

  radiusOf(index) {
    return this.vertices[index].radius ?? this.content.corner_radius;
  }

  hasCorner(index) {
    return this.content.closed || (index > 0 && index < this.vertices.length - 1);
  }

  // The pairs of corners that a line joins, by the index of the second.
  *lines() {
    const all = this.vertices;
    for (let k = 1; k < all.length; k += 1) yield [all[k - 1], all[k], k];
    if (this.content.closed && all.length > 2) yield [all[all.length - 1], all[0], all.length];
  }

  // Where the handle of a corner's radius is: in the middle of its arc, m.
  handle(index) {
    const all = this.vertices;
    if (!this.hasCorner(index) || all.length < 3) return null;
    const corner = all[index];
    const [a, b] = [all[(index + all.length - 1) % all.length], all[(index + 1) % all.length]];
    const [ua, ub] = [unit(corner, a), unit(corner, b)];
    if (!ua || !ub) return null;
    const middle = [ua[0] + ub[0], ua[1] + ub[1]];
    const length = Math.hypot(...middle);
    if (length < 1e-6) return null;
    const half = Math.acos(Math.min(1, length / 2));
    const off = this.radiusOf(index) * (1 / Math.sin(half) - 1);
    return { x: corner.x + (off * middle[0]) / length, y: corner.y + (off * middle[1]) / length, half };
  }

  // The radius that puts a corner's handle at a distance, m, from it.
  radiusFor(index, distance) {
    const { half } = this.handle(index);
    return Math.max(0.1, Math.round((distance / (1 / Math.sin(half) - 1)) * 100) / 100);
  }
}

function unit(from, to) {
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  const length = Math.hypot(dx, dy);
  return length ? [dx / length, dy / length] : null;
}

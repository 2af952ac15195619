// The team's state on the page: one Robot per id, updated by messages.

const SAMPLES = 3600;
const PARTS = ["pose", "decision", "status", "scan", "particles", "tracks", "process", "event"];

class Robot {
  constructor(id, number) {
    this.id = id;
    this.number = number;
    this.mark = String(number + 1); // beside its colour, which others may share; the key that chooses it
    this.name = id;
    this.samples = [];
    this.at = {}; // part -> monitor time of its arrival
  }

  take(message, now) {
    this.name = message.name;
    this.team = message.team;
    this.online = message.online;
    this.heard = message.heard;
    this.malformed = message.malformed;
    this.why = message.why;
    this.turned = message.turned;
    for (const part of PARTS) {
      if (part in message) {
        this[part] = message[part];
        this.at[part] = now;
      }
    }
    for (const sample of message.history ?? []) this.addSample(sample);
  }

  // A sample: wall time (s), x, y (m), distance from border (m), index of the action.
  addSample(sample) {
    this.samples.push(sample);
    if (this.samples.length > SAMPLES) this.samples.shift();
  }

  // The words beside it on the map: its name, with the number if that does not end in it.
  get label() {
    return this.name.endsWith(this.mark) ? this.name : `${this.mark} ${this.name}`;
  }

  // Returns the age of a part, s; infinite if none was received.
  age(part, now) {
    return part in this.at ? now - this.at[part] : Infinity;
  }

  silent(now) {
    return this.heard === null || this.heard === undefined || now - this.heard > 1.5;
  }
}

export class Team {
  constructor() {
    this.clear();
  }

  clear() {
    this.robots = new Map();
    this.ordered = [];
    this.alarms = [];
    this.coverage = null;
    this.log = null;
    this.source = { kind: "live" };
    this.now = 0;
    this.wall = 0;
  }

  take(message) {
    if (message.fresh) this.clear();
    this.now = message.now;
    this.wall = message.wall;
    this.source = message.source;
    this.log = message.log ?? null;
    if (message.shown) this.keep(new Set(message.shown));
    for (const part of message.robots) this.robot(part.id).take(part, message.now);
    if (message.alarms) this.alarms = message.alarms;
    if (message.coverage) this.coverage = message.coverage;
  }

  // Returns the active alarms, the worst first.
  active() {
    return this.alarms.filter((alarm) => alarm.cleared === null);
  }

  // Returns the severity of each robot's worst active alarm, of those that have any.
  troubles() {
    const worst = new Map();
    for (const alarm of this.active()) if (!worst.has(alarm.robot)) worst.set(alarm.robot, alarm.severity);
    return worst;
  }

  // Removes the robots that gave way to others.
  keep(shown) {
    for (const id of [...this.robots.keys()]) if (!shown.has(id)) this.robots.delete(id);
    this.order();
  }

  order() {
    this.ordered = [...this.robots.values()].sort((a, b) => a.id.localeCompare(b.id, undefined, { numeric: true }));
  }

  robot(id) {
    if (!this.robots.has(id)) {
      this.robots.set(id, new Robot(id, this.freeNumber(id)));
      this.order();
    }
    return this.robots.get(id);
  }

  // Returns a colour's number: the one the name ends in, so that it is stable, or a free one.
  freeNumber(id) {
    const taken = new Set(this.ordered.map((robot) => robot.number));
    const own = Number(id.match(/\d{1,3}$/)?.[0] ?? 0) - 1;
    if (own >= 0 && !taken.has(own)) return own;
    let number = 0;
    while (taken.has(number)) number += 1;
    return number;
  }
}

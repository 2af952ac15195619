// The samples that plots show, and over which time: live up to the present, of surveyed recordings all round it.

import { sampleAt } from "./plot.js";

export class History {
  constructor(team, roster) {
    this.team = team;
    this.roster = roster;
    this.span = 300; // s
    this.surveyed = null; // samples by robot id; null: no survey, or not done yet
  }

  async load() {
    this.surveyed = await (await fetch("/history")).json();
  }

  samples(robot) {
    return this.surveyed?.[robot.id] ?? robot.samples;
  }

  // Returns the times shown, s since 1970, and the present among them.
  window() {
    const { wall, source } = this.team;
    if (!this.surveyed) return { from: wall - this.span, to: wall, present: wall };
    const span = Math.max(Math.min(this.span, source.end - source.start), 1);
    const from = Math.max(Math.min(wall - span / 2, source.end - span), source.start);
    return { from, to: from + span, present: wall };
  }

  // Returns [robot, sample] of each plotted robot that has one at a time.
  at(time) {
    const pairs = this.roster.plotted().map((robot) => [robot, sampleAt(this.samples(robot), time)]);
    return pairs.filter(([, sample]) => sample);
  }
}

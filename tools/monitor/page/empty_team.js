// What the page says while no robot has reported: what robots dial, and where that is set.

import { element } from "./element.js";

const ASK_MS = 5000;

export class EmptyTeam {
  constructor(box) {
    this.box = box;
    this.askedAt = -Infinity;
  }

  show(team) {
    this.box.hidden = team.ordered.length > 0;
    if (this.box.hidden || performance.now() - this.askedAt < ASK_MS) return;
    this.askedAt = performance.now();
    this.ask();
  }

  async ask() {
    const { endpoints, onlyHere } = await (await fetch("/dial.json")).json();
    if (!endpoints.length) {
      this.box.replaceChildren(element("p", "", "No robot is in the recordings at this time."));
      return;
    }
    const parts = [
      element("p", "", "No robot has reported yet. Robots dial"),
      ...endpoints.map((endpoint) => element("code", "", endpoint)),
      element("p", "", "It is set in each robot's file:"),
      element("pre", "", `[telemetry]\noperator = "${endpoints[0]}"`),
    ];
    if (onlyHere) {
      parts.push(element("p", "warn", "Only robots on this computer reach that: for others start the monitor with --listen tcp/0.0.0.0:7447"));
    }
    this.box.replaceChildren(...parts);
  }
}

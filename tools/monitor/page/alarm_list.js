// The alarms, active ones first. Acknowledging is sent to the monitor, never to a robot.

import { element, setText } from "./element.js";
import { timeOfDay } from "./format.js";

const MARKS = { critical: "▲", warning: "◆", info: "●" };

export class AlarmList {
  // go: shows an alarm's robot on the map.
  constructor(list, counter, all, send, robotName, go) {
    this.list = list;
    this.counter = counter;
    this.all = all;
    this.send = send;
    this.robotName = robotName;
    this.go = go;
    this.items = new Map();
    this.alarms = [];
    all.addEventListener("click", () => this.acknowledge(this.unseen()));
  }

  unseen() {
    return this.alarms.filter((alarm) => !alarm.acknowledged);
  }

  acknowledge(alarms) {
    for (const alarm of alarms) this.send({ acknowledge: alarm.number });
  }

  acknowledgeFirst() {
    this.acknowledge(this.unseen().slice(0, 1));
  }

  // mayAct: whether this page was opened with the token that the monitor prints.
  show(alarms, mayAct) {
    if (alarms === this.alarms) return;
    this.alarms = alarms;
    const active = alarms.filter((alarm) => alarm.cleared === null);
    const unseen = this.unseen();
    setText(this.counter, active.length ? `${active.length} active` : "");
    this.mayAct = mayAct;
    this.all.hidden = unseen.length < 2 || !mayAct;
    const numbers = new Set(alarms.map((alarm) => alarm.number));
    for (const [number, item] of this.items) {
      if (!numbers.has(number)) {
        item.root.remove();
        this.items.delete(number);
      }
    }
    this.showNone(!alarms.length);
    let before = null;
    for (const alarm of alarms) {
      const item = this.item(alarm);
      this.update(item, alarm);
      // Move only items out of place: moving one takes the keyboard focus away.
      const expected = before ? before.nextElementSibling : this.list.firstElementChild;
      if (expected !== item.root) this.list.insertBefore(item.root, expected);
      before = item.root;
    }
  }

  showNone(wanted) {
    const none = this.list.querySelector(".none");
    if (none && !wanted) none.remove();
    if (!none && wanted) this.list.append(element("li", "none", "Nothing to report."));
  }

  item(alarm) {
    if (!this.items.has(alarm.number)) {
      const root = element("li");
      const [mark, words, button] = [element("span", "mark"), element("button", "words"), element("button", "ok", "OK")];
      const [text, when] = [element("span"), element("span", "when quiet")];
      button.type = words.type = "button";
      words.addEventListener("click", () => this.go(this.alarms.find((each) => each.number === alarm.number)));
      button.addEventListener("click", () => this.send({ acknowledge: alarm.number }));
      words.append(text, when);
      root.append(mark, words, button);
      this.items.set(alarm.number, { root, mark, text, when, button });
    }
    return this.items.get(alarm.number);
  }

  update(item, alarm) {
    const over = alarm.cleared !== null;
    item.root.className = `${alarm.severity}${over ? " over" : ""}${alarm.acknowledged ? " seen" : ""}`;
    item.root.dataset.kind = alarm.kind;
    item.root.dataset.robot = alarm.robot;
    setText(item.mark, MARKS[alarm.severity] ?? "●");
    item.mark.setAttribute("aria-label", alarm.severity);
    setText(item.text, `${alarm.robot ? `${this.robotName(alarm.robot)}: ` : ""}${alarm.text}`);
    const times = `${timeOfDay(alarm.raised)}${over ? ` – ${timeOfDay(alarm.cleared)} over` : ""}`;
    setText(item.when, alarm.acknowledged ? `${times}, acknowledged` : times);
    item.button.hidden = alarm.acknowledged || !this.mayAct;
    item.button.setAttribute("aria-label", `acknowledge ${alarm.text}`);
  }
}

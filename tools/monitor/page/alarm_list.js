// The alarms, active ones first. Acknowledging is sent to the monitor, never to a robot.

import { AlarmItem } from "./alarm_item.js";
import { element, setText } from "./element.js";

export class AlarmList {
  // acknowledge: called with an alarm; robotName: of an id; go: shows an alarm on the map.
  constructor(list, counter, all, { acknowledge, robotName, go }) {
    this.list = list;
    this.counter = counter;
    this.all = all;
    this.acknowledge = acknowledge;
    this.robotName = robotName;
    this.go = go;
    this.items = new Map();
    this.alarms = [];
    all.addEventListener("click", () => this.unseen().forEach(acknowledge));
  }

  unseen() {
    return this.alarms.filter((alarm) => !alarm.acknowledged);
  }

  acknowledgeFirst() {
    this.unseen().slice(0, 1).forEach(this.acknowledge);
  }

  // Numbers begin anew in a playback that jumps.
  clear() {
    for (const item of this.items.values()) item.root.remove();
    this.items.clear();
    this.alarms = [];
  }

  // mayAct: whether this page was opened with the token that the monitor prints.
  show(alarms, mayAct) {
    if (alarms === this.alarms) return;
    this.alarms = alarms;
    const active = alarms.filter((alarm) => alarm.cleared === null);
    setText(this.counter, active.length ? `${active.length} active` : "");
    this.all.hidden = this.unseen().length < 2 || !mayAct;
    const numbers = new Set(alarms.map((alarm) => alarm.number));
    for (const [number, item] of this.items) {
      if (numbers.has(number)) continue;
      item.root.remove();
      this.items.delete(number);
    }
    this.showNone(!alarms.length);
    let before = null;
    for (const alarm of alarms) {
      const item = this.item(alarm.number);
      item.update(alarm, alarm.robot && this.robotName(alarm.robot), mayAct);
      // Move only items out of place: moving one takes the keyboard focus away.
      const expected = before ? before.nextElementSibling : this.list.firstElementChild;
      if (expected !== item.root) this.list.insertBefore(item.root, expected);
      before = item.root;
    }
  }

  showAges(wall) {
    for (const alarm of this.alarms) if (alarm.seen !== null) this.item(alarm.number).showAge(alarm, wall);
  }

  showNone(wanted) {
    const none = this.list.querySelector(".none");
    if (none && !wanted) none.remove();
    if (!none && wanted) this.list.append(element("li", "none", "Nothing to report."));
  }

  item(number) {
    if (!this.items.has(number)) {
      const present = () => this.alarms.find((alarm) => alarm.number === number);
      this.items.set(number, new AlarmItem(() => this.go(present()), () => this.acknowledge(present())));
    }
    return this.items.get(number);
  }
}

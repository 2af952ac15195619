// One alarm in the list: what, where, when, the picture of an intruder, who acknowledged it.

import { element, setText } from "./element.js";
import { duration, timeOfDay } from "./format.js";

const MARKS = { critical: "▲", warning: "◆", info: "●" };

export class AlarmItem {
  // go, acknowledge: called without arguments by a click on the words, and on OK.
  constructor(go, acknowledge) {
    this.root = element("li");
    this.mark = element("span", "mark");
    this.mark.setAttribute("role", "img");
    this.words = element("button", "words");
    this.button = element("button", "ok", "OK");
    this.words.type = this.button.type = "button";
    this.words.addEventListener("click", go);
    this.button.addEventListener("click", acknowledge);
    this.text = element("span");
    this.seen = element("span", "when");
    this.seen.setAttribute("aria-live", "off"); // it changes every second
    this.when = element("span", "when quiet");
    this.words.append(this.text, this.seen, this.when);
    this.root.append(this.mark, this.words, this.button);
    this.picture = null;
  }

  // name: of the robot, empty for the monitor itself; mayAct: whether OK is offered.
  update(alarm, name, mayAct) {
    const over = alarm.cleared !== null;
    this.root.className = `${alarm.severity}${over ? " over" : ""}${alarm.acknowledged ? " seen" : ""}`;
    this.root.dataset.kind = alarm.kind;
    this.root.dataset.robot = alarm.robot;
    setText(this.mark, MARKS[alarm.severity] ?? "●");
    this.mark.setAttribute("aria-label", alarm.severity);
    setText(this.text, `${name ? `${name}: ` : ""}${alarm.text}`);
    const times = `${timeOfDay(alarm.raised)}${over ? ` – ${timeOfDay(alarm.cleared)} over` : ""}`;
    const by = alarm.by ? ` by ${alarm.by}` : "";
    setText(this.when, alarm.acknowledged ? `${times}, acknowledged${by}` : times);
    this.button.hidden = alarm.acknowledged || !mayAct;
    this.button.setAttribute("aria-label", `OK, acknowledge ${alarm.text}`);
    this.showPicture(alarm, name);
  }

  showPicture(alarm, name) {
    if (!alarm.picture) return;
    if (!this.picture) {
      this.picture = element("img");
      this.picture.alt = `picture of the intruder by ${name}`;
      this.root.append(this.picture);
    }
    const source = `/intruder/${alarm.number}?${alarm.picture}`;
    if (this.picture.getAttribute("src") !== source) this.picture.src = source;
  }

  // wall: the present, s since 1970.
  showAge(alarm, wall) {
    setText(this.seen, alarm.seen === null ? "" : `last seen ${duration(Math.max(wall - alarm.seen, 0))} ago`);
  }
}

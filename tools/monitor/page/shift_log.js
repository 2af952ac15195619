// The shift log: every alarm of this and earlier runs of the monitor, filtered, and as a file.

import { element, setText } from "./element.js";
import { dateAndTime, duration } from "./format.js";

const TYPING_MS = 250;

export class ShiftLog {
  // go: shows an entry's place, and time, on the map.
  constructor(dialog, button, robotName, go) {
    this.dialog = dialog;
    this.robotName = robotName;
    this.go = go;
    this.version = null;
    this.entries = [];
    this.form = dialog.querySelector("form[role=search]");
    this.rows = dialog.querySelector("tbody");
    this.count = dialog.querySelector(".count");
    button.addEventListener("click", () => this.open());
    this.form.addEventListener("submit", (event) => event.preventDefault());
    this.form.addEventListener("input", () => {
      clearTimeout(this.typing);
      this.typing = setTimeout(() => this.load(), TYPING_MS);
    });
  }

  open() {
    this.dialog.showModal();
    this.load();
  }

  // version: of the monitor's log; null if it keeps none.
  take(version, button) {
    button.hidden = version === null;
    if (version === this.version) return;
    this.version = version;
    if (this.dialog.open && version !== null) this.load();
  }

  query() {
    const query = new URLSearchParams();
    for (const [name, value] of new FormData(this.form)) {
      if (!value) continue;
      query.set(name, name === "since" || name === "until" ? new Date(value).getTime() / 1000 : value);
    }
    return query;
  }

  async load() {
    const query = this.query();
    for (const link of this.dialog.querySelectorAll("a[data-file]")) link.href = `/${link.dataset.file}?${query}`;
    const answer = await fetch(`/log?${query}`);
    if (!answer.ok) return;
    this.entries = await answer.json();
    this.offerRobots();
    setText(this.count, `${this.entries.length} ${this.entries.length === 1 ? "alarm" : "alarms"}`);
    this.rows.replaceChildren(...this.entries.map((entry) => this.row(entry)));
  }

  // Offers each robot that was ever seen in the log.
  offerRobots() {
    const select = this.form.elements.robot;
    const known = new Set([...select.options].map((option) => option.value));
    for (const { robot } of this.entries) {
      if (!robot || known.has(robot)) continue;
      known.add(robot);
      select.append(new Option(robot, robot));
    }
  }

  row(entry) {
    const row = element("tr", entry.severity);
    const what = element("td");
    const words = element("button", "words", entry.text);
    words.type = "button";
    words.addEventListener("click", () => {
      this.dialog.close();
      this.go(entry);
    });
    what.append(words);
    if (entry.pictured) {
      const picture = element("img");
      picture.loading = "lazy";
      picture.src = `/log/${entry.id}.jpg`;
      picture.alt = "picture of the intruder";
      what.append(picture);
    }
    const ended = entry.cleared === null ? "" : duration(entry.cleared - entry.raised);
    row.append(
      element("td", "", dateAndTime(entry.raised)), element("td", "", ended), element("td", "severity", entry.severity),
      element("td", "", entry.robot ? this.robotName(entry.robot) : "monitor"), what,
      element("td", "", acknowledged(entry)),
    );
    return row;
  }
}

function acknowledged(entry) {
  if (entry.acknowledged === null) return "";
  return `${dateAndTime(entry.acknowledged)}${entry.acknowledged_by ? ` by ${entry.acknowledged_by}` : ""}`;
}

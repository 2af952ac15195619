// The header: the worst active alarm in its colour, the team in one line, the time; the tab counts alarms.

import { setText } from "./element.js";
import { duration, timeOfDay } from "./format.js";

const find = (id) => document.getElementById(id);

export class Header {
  // robotName: of an id; go: shows an alarm on the map.
  constructor(team, figures, robotName, go) {
    this.team = team;
    this.figures = figures;
    this.robotName = robotName;
    find("trouble").firstElementChild.addEventListener("click", () => go(team.active()[0]));
  }

  show() {
    setText(find("clock"), this.team.wall ? timeOfDay(this.team.wall) : "");
    setText(find("summary"), this.summary());
    this.showTrouble();
    setText(find("figures"), this.figures.words(this.team.source.kind === "live"));
  }

  showLink(up) {
    const words = !up ? "monitor gone" : this.team.source.kind === "live" ? "live" : "playback";
    const chip = find("link");
    setText(chip, words);
    chip.className = `chip ${up ? "good" : "bad"}`;
    document.body.classList.toggle("gone", !up);
  }

  showTrouble() {
    const active = this.team.active();
    const [worst] = active;
    const name = worst && (worst.robot ? this.robotName(worst.robot) : "monitor");
    const box = find("trouble");
    setText(box.firstElementChild, worst ? `${name}: ${worst.text}` : "");
    setText(box.lastElementChild, active.length > 1 ? ` · ${active.length - 1} more` : "");
    box.className = `trouble ${worst?.severity ?? ""}`;
    box.hidden = !worst;
    const title = active.length ? `(${active.length}) Border patrol` : "Border patrol";
    if (document.title !== title) document.title = title;
  }

  summary() {
    const { team } = this;
    const heard = team.ordered.filter((robot) => !robot.silent(team.now));
    const held = heard.filter((robot) => robot.status && robot.status.health !== "ok");
    const robots = `${heard.length} of ${team.ordered.length} robots heard`;
    const allWell = team.ordered.length && heard.length === team.ordered.length && !team.active().length;
    const well = held.length ? `${held.length} held back` : allWell ? "all well" : "";
    const idle = team.coverage ? `border unseen ${duration(team.coverage.average)} on average` : "";
    return [robots, well, idle].filter(Boolean).join(" · ");
  }
}

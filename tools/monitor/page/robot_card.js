// One robot's card: action, reason and main figures; every figure when opened.

import { element, setClass, setText } from "./element.js";
import { ABSENT, actionName, count, quantity, timeOfDay, twist } from "./format.js";
import { robotVariable } from "./palette.js";

const LOG_LINES = 4;
const LEVEL_CLASS = { 3: "worry", 4: "bad", 5: "bad" };

const FACTS = [
  ["border", "from border"], ["neighbor", "nearest"],
  ["abscissa", "along border"], ["gamma", "neighbor state"],
  ["zone", "in", "wide"],
  ["requested", "asked for", "wide"], ["command", "after gate", "wide"], ["gate", "gate", "wide"],
  ["override", "beyond the rules", "wide"], ["turned", "turned last", "wide"],
  ["localization", "localization", "wide"],
  ["battery", "battery"], ["motors", "motors"],
  ["base", "base link", "wide"], ["laser", "laser link", "wide"],
  ["cpu", "CPU"], ["memory", "memory"],
  ["late", "latest step"], ["clock", "clock"],
  ["dropped", "not sent"], ["lost", "not recorded"],
];

export class RobotCard {
  // zones: the site's named places.
  constructor(robot, actions, zones, { choose, pin }) {
    this.robot = robot;
    this.zones = zones;
    this.actions = actions;
    this.root = element("article", "card");
    this.root.dataset.robot = robot.id;
    this.root.style.setProperty("--robot", robotVariable(robot.number));
    this.button = element("button", "row");
    this.button.type = "button";
    this.button.addEventListener("click", choose);
    this.pin = element("button", "pin", "Plot");
    this.pin.type = "button";
    this.pin.title = "plot only the robots chosen so";
    this.pin.addEventListener("click", () => pin(this.pin.getAttribute("aria-pressed") !== "true"));
    this.mark = element("span", "mark", robot.mark);
    this.badge = element("span", "badge");
    this.badge.setAttribute("role", "img");
    this.name = element("span", "name");
    this.action = element("span", "action");
    this.brief = element("span", "brief");
    this.why = element("span", "why");
    const title = element("span");
    title.append(this.badge, " ", this.mark, " ", this.name, " ", this.action); // spaces are for who listens
    this.button.append(title, this.brief, this.why);
    this.root.append(this.button, this.pin);
    this.body = null;
    this.open = false;
  }

  setOpen(open) {
    this.open = open;
    if (open && !this.body) this.makeBody();
    if (this.body) this.body.hidden = !open;
    this.button.setAttribute("aria-expanded", String(open));
  }

  makeBody() {
    this.body = element("div", "body");
    this.body.append(this.makeBars(), this.makeFacts());
    this.log = element("ol", "log");
    this.body.append(this.log);
    this.root.append(this.body);
  }

  makeBars() {
    const box = element("div", "bars");
    this.bars = this.actions.map((action, index) => {
      const label = element("span", "label");
      const bar = element("span", "bar");
      const fill = element("i");
      fill.style.background = `var(--action-${index})`;
      const value = element("span", "value");
      value.dataset.degree = action;
      bar.append(fill);
      box.append(label, bar, value);
      return { action, label, fill, value };
    });
    return box;
  }

  makeFacts() {
    const list = element("dl", "facts");
    this.facts = {};
    for (const [key, words, wide] of FACTS) {
      const value = element("dd", wide ?? "");
      value.dataset.fact = key;
      list.append(element("dt", "", words), value);
      this.facts[key] = value;
    }
    return list;
  }

  // trouble: severity of its worst active alarm, empty without one; pinned: chosen for the plots.
  update(now, { chosen, trouble, pinned }) {
    const { robot } = this;
    const silent = robot.silent(now);
    setClass(this.root, "chosen", chosen);
    setClass(this.root, "silent", silent);
    for (const severity of ["critical", "warning"]) setClass(this.root, severity, trouble === severity);
    setText(this.badge, trouble === "critical" ? "▲" : trouble === "warning" ? "◆" : "");
    this.badge.setAttribute("aria-label", trouble ? `${trouble} alarm` : "no alarm");
    this.badge.hidden = !trouble || trouble === "info";
    setText(this.name, robot.name);
    this.pin.setAttribute("aria-label", `Plot ${robot.name}`);
    this.pin.setAttribute("aria-pressed", String(pinned));
    const current = robot.decision && robot.age("decision", now) < 1.5;
    setText(this.action, silent ? "silent" : current ? actionName(robot.decision.action) : "no decision");
    setText(this.why, robot.why);
    setText(this.brief, this.briefWords(now, silent));
    if (this.open) this.updateBody();
  }

  briefWords(now, silent) {
    const { robot } = this;
    if (silent) {
      return robot.heard === null || robot.heard === undefined ? "never heard" : `${Math.round(now - robot.heard)} s ago`;
    }
    return `${quantity(robot.decision?.border, "m")} · ${quantity(robot.status?.battery, "V", 1)}`;
  }

  // The name of the zone that it is in; empty without a pose.
  zone() {
    const { pose } = this.robot;
    return pose ? this.zones.nameAt(pose[0], pose[1]) : "";
  }

  updateBody() {
    this.updateBars();
    this.updateDecision();
    this.updateStatus();
    this.updateLog();
  }

  updateBars() {
    const { decision } = this.robot;
    this.bars.forEach(({ action, label, fill, value }, index) => {
      const degree = decision?.degrees[index];
      const [winner, runner] = [decision?.winner === action, decision?.runnerUp === action];
      setText(label, `${actionName(action)}${winner ? " ◀" : runner ? " ◁" : ""}`);
      label.title = winner ? "winner" : runner ? "runner-up" : "";
      setClass(label, "winner", winner);
      setClass(label, "runner", runner && !winner);
      fill.style.transform = `scaleX(${Math.min(Math.max(degree ?? 0, 0), 1)})`;
      setText(value, quantity(degree, ""));
    });
  }

  updateDecision() {
    const { decision } = this.robot;
    const { facts } = this;
    const way = decision?.way;
    const around = typeof way === "number" && way - decision.border > 0.1 ? ` (${quantity(way, "m", 1)} round)` : "";
    setText(facts.border, quantity(decision?.border, "m") + around);
    setText(facts.neighbor, quantity(decision?.neighbor, "m"));
    setText(facts.gamma, quantity(decision?.gamma, ""));
    setText(facts.abscissa, decision ? `${quantity(decision.abscissa, "m", 1)} ${decision.direction > 0 ? "cw" : "ccw"}` : ABSENT);
    setText(facts.zone, this.zone() || ABSENT);
    setText(facts.requested, twist(decision?.requested));
    setText(facts.command, twist(decision?.command));
    setText(facts.gate, decision ? (decision.gate ?? "lets all through") : ABSENT);
    setClass(facts.gate, "worry", Boolean(decision?.gate) && decision.gate !== "acceleration");
    setText(facts.override, decision ? (decision.override?.replaceAll("_", " ") ?? "none") : ABSENT);
    setText(facts.turned, this.robot.turned || ABSENT);
  }

  updateStatus() {
    const { status, process } = this.robot;
    const { facts } = this;
    setText(facts.localization, status ? localizationWords(status.localization) : ABSENT);
    setClass(facts.localization, "bad", status?.localization.health === "lost");
    setClass(facts.localization, "worry", status?.localization.health === "unsure");
    setText(facts.battery, quantity(status?.battery, "V", 1));
    setClass(facts.battery, "bad", status?.battery < 11.5);
    setText(facts.motors, status ? motorWords(status) : ABSENT);
    setClass(facts.motors, "bad", Boolean(status?.stalled || status?.bumpers));
    for (const link of ["base", "laser"]) {
      setText(facts[link], status ? linkWords(status[link]) : ABSENT);
      setClass(facts[link], "bad", Boolean(status && (!status[link].up || status[link].trouble)));
    }
    setText(facts.cpu, process ? quantity(100 * process.cpu, "%", 1) : ABSENT);
    setText(facts.memory, quantity(process?.memory, "MB", 0));
    setText(facts.late, process ? quantity(1000 * process.late, "ms", 0) : ABSENT);
    setText(facts.dropped, count(process?.dropped));
    setText(facts.lost, count(process?.lost));
    setText(facts.clock, typeof status?.skew === "number" ? `${status.skew >= 0 ? "+" : "−"}${Math.abs(status.skew).toFixed(2)} s` : ABSENT);
  }

  updateLog() {
    const events = this.robot.event;
    if (!events || events === this.shownEvents) return;
    this.shownEvents = events;
    this.log.replaceChildren(
      ...events.slice(-LOG_LINES).reverse().map(([wall, level, part, words]) =>
        element("li", LEVEL_CLASS[level] ?? "", `${timeOfDay(wall)} ${part}: ${words}`)),
    );
  }
}

function localizationWords(localization) {
  const [a, , , , d] = localization.covariance;
  const sigma = localization.covariance.length === 9 ? `, σ ${quantity(100 * Math.sqrt(Math.max(a + d, 0)), "cm", 1)}` : "";
  return `${localization.health}${sigma}, n ${localization.particles}, fit ${quantity(localization.likelihood, "")}`;
}

function motorWords(status) {
  const words = [status.motors ? "on" : "off"];
  if (status.stalled) words.push("stalled");
  if (status.bumpers) words.push("bumper");
  return words.join(", ");
}

function linkWords(link) {
  if (!link.up) return link.reason || "port not open";
  const line = `${link.state}, ${quantity(link.rate, "/s", 1)}, ${link.bad} bad, ${link.discarded} B lost`;
  return [line, link.happened, link.trouble].filter(Boolean).join("; ");
}

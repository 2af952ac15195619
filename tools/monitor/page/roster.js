// Which robots are listed, in which order, and which are plotted: by search, filter and pins.

const KEY = "patrol.pinned";
const RANK = { critical: 0, warning: 1, info: 2 };

const FILTERS = {
  all: () => true,
  trouble: (robot, { worst }) => worst.has(robot.id),
  silent: (robot, { now }) => robot.silent(now),
  pinned: (robot, { pinned }) => pinned.has(robot.id),
};

export class Roster {
  constructor(team, zones) {
    this.team = team;
    this.zones = zones;
    this.words = "";
    this.filter = "all";
    this.pinned = new Set(JSON.parse(localStorage.getItem(KEY) ?? "[]"));
  }

  // Returns the robots that match, those in the worst trouble first, else by name.
  listed() {
    const worst = this.team.troubles();
    const facts = { worst, now: this.team.now, pinned: this.pinned };
    const rank = (robot) => RANK[worst.get(robot.id)] ?? 3;
    const matching = this.team.ordered.filter((robot) => FILTERS[this.filter](robot, facts) && this.found(robot));
    return matching.sort((a, b) => rank(a) - rank(b));
  }

  // Returns the pinned robots, or without any the listed ones, by name.
  plotted() {
    const pinned = this.team.ordered.filter((robot) => this.pinned.has(robot.id));
    if (pinned.length) return pinned;
    const listed = new Set(this.listed());
    return this.team.ordered.filter((robot) => listed.has(robot));
  }

  // Whether a robot's number, name, doing or zone has the words searched for.
  found(robot) {
    const words = this.words.trim().toLowerCase();
    if (!words) return true;
    const zone = robot.pose ? this.zones.nameAt(robot.pose[0], robot.pose[1]) : "";
    return robot.mark === words || `${robot.id} ${robot.why} ${zone}`.toLowerCase().includes(words);
  }

  pin(id, wanted) {
    if (wanted) this.pinned.add(id);
    else this.pinned.delete(id);
    localStorage.setItem(KEY, JSON.stringify([...this.pinned]));
  }
}

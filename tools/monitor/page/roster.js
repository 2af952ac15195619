// Which robots are listed, in which order, and which are plotted: by search, filter and pins.

const KEY = "patrol.pinned";
const RANK = { critical: 0, warning: 1, info: 2 };

const FILTERS = {
  all: () => true,
  trouble: (team, robot) => team.trouble(robot.id) !== "",
  silent: (team, robot) => robot.silent(team.now),
  pinned: (team, robot, roster) => roster.pinned.has(robot.id),
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
    const { team } = this;
    const rank = (robot) => RANK[team.trouble(robot.id)] ?? 3;
    const matching = team.ordered.filter((robot) => FILTERS[this.filter](team, robot, this) && this.found(robot));
    const ranks = new Map(matching.map((robot) => [robot, rank(robot)]));
    return matching.sort((a, b) => ranks.get(a) - ranks.get(b));
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

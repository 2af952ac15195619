// How well the page keeps up: redraws per second, and how old the newest pose is when drawn.

const WINDOW = 100;

export class Figures {
  constructor() {
    this.draws = [];
    this.delays = []; // ms from a pose's own time stamp to its drawing; needs clocks that agree
    this.newest = 0;
  }

  drawn(team) {
    const now = performance.now();
    this.draws.push(now);
    if (this.draws.length > WINDOW) this.draws.shift();
    let newest = this.newest;
    for (const robot of team.ordered) if (robot.pose?.[3] > newest) newest = robot.pose[3];
    if (newest > this.newest) {
      this.newest = newest;
      this.delays.push(Date.now() - 1000 * newest);
      if (this.delays.length > 5000) this.delays.shift();
    }
  }

  rate() {
    const since = performance.now() - 2000;
    return this.draws.filter((time) => time > since).length / 2;
  }

  words(live) {
    const delay = this.delays[this.delays.length - 1];
    const rate = `${Math.round(this.rate())} frames/s`;
    return live && delay !== undefined ? `${rate} · ${Math.round(delay)} ms behind` : rate;
  }
}

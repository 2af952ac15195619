// The page's performance: redraws per second, and the age of poses when they are drawn.

const WINDOW = 100;
const DELAYS = 20000;

export class Figures {
  constructor() {
    this.count = 0;
    this.draws = [];
    this.delays = []; // ms from a pose's own time stamp to its drawing; needs clocks that agree
  }

  drawn(team) {
    const now = performance.now();
    this.count += 1;
    this.draws.push(now);
    if (this.draws.length > WINDOW) this.draws.shift();
    const wall = Date.now();
    for (const robot of team.ordered) {
      if (!robot.pose || robot.pose === robot.drawnPose) continue;
      robot.drawnPose = robot.pose;
      this.delays.push(wall - 1000 * robot.pose[3]);
    }
    if (this.delays.length > DELAYS) this.delays.splice(0, DELAYS / 2);
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

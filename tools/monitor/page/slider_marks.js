// The alarms of a whole recording as marks over its slider; a click goes there.

import { colour } from "./palette.js";
import { Surface } from "./surface.js";

const NEAR = 6; // px
const RANK = { info: 0, warning: 1, critical: 2 };

export class SliderMarks {
  // range: returns start and end of the recording, s since 1970; go: called with an alarm of the log.
  constructor(canvas, range, go) {
    this.range = range;
    this.entries = [];
    this.surface = new Surface(canvas, () => this.draw());
    canvas.addEventListener("click", (event) => {
      const entry = this.nearest(event.offsetX);
      if (entry) go(entry);
    });
    canvas.addEventListener("pointermove", (event) => {
      canvas.title = this.nearest(event.offsetX)?.text ?? "";
    });
    this.canvas = canvas;
  }

  async load() {
    this.entries = await (await fetch("/log")).json();
    this.entries.sort((a, b) => RANK[a.severity] - RANK[b.severity]); // the worst are drawn last
    this.canvas.setAttribute("aria-label", `${this.entries.length} alarms in the recording; the shift log lists them`);
    this.draw();
  }

  x(time) {
    const { start, end } = this.range();
    return ((time - start) / Math.max(end - start, 1e-9)) * (this.surface.width - 16) + 8; // the thumb's half
  }

  nearest(px) {
    const [best] = [...this.entries].reverse().sort((a, b) => Math.abs(this.x(a.raised) - px) - Math.abs(this.x(b.raised) - px));
    return best && Math.abs(this.x(best.raised) - px) <= NEAR ? best : null;
  }

  draw() {
    if (!this.surface.width) return;
    const context = this.surface.begin();
    for (const entry of this.entries) {
      context.fillStyle = colour(entry.severity);
      context.fillRect(this.x(entry.raised) - 1, entry.severity === "critical" ? 0 : 3, 2.5, this.surface.height);
    }
  }
}

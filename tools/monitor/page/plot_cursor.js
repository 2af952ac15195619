// A time in the history that both plots and the playback's slider show: under the pointer, or moved by keys.

const STEP = 1 / 60; // of the time shown, for one press of an arrow key

export class PlotCursor {
  // onChange: redraws; onGo: called with a time that was clicked, or chosen by Enter.
  constructor(onChange, onGo) {
    this.time = null; // s since 1970; null: no cursor
    this.onChange = onChange;
    this.onGo = onGo;
  }

  set(time) {
    if (time === this.time) return;
    this.time = time;
    this.onChange();
  }

  // axis: returns the plot's present time axis.
  listen(canvas, axis) {
    const at = (event) => axis().time(event.clientX - canvas.getBoundingClientRect().left);
    canvas.addEventListener("pointermove", (event) => this.set(at(event)));
    canvas.addEventListener("pointerleave", () => this.set(null));
    canvas.addEventListener("blur", () => this.set(null));
    canvas.addEventListener("click", (event) => this.onGo(at(event)));
    canvas.addEventListener("keydown", (event) => this.key(event, axis()));
  }

  key(event, axis) {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (way) {
      const from = this.time ?? axis.present;
      this.set(Math.min(Math.max(from + way * STEP * (axis.to - axis.from), axis.from), axis.to));
    } else if (event.key === "Enter" && this.time !== null) {
      this.onGo(this.time);
    } else if (event.key === "Escape") {
      this.set(null);
    } else {
      return;
    }
    event.preventDefault();
  }
}

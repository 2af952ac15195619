// Controls of a playback: pause, speed and a time slider.

import { element, setText } from "./element.js";
import { duration, timeOfDay } from "./format.js";
import { SliderMarks } from "./slider_marks.js";

const SPEEDS = [0.5, 1, 2, 5, 10, 30];

export class PlaybackBar {
  // go: called with an alarm of the log whose mark was clicked.
  constructor(box, send, go) {
    this.box = box;
    this.send = send;
    this.source = null;
    this.dragging = false;
    this.button = element("button", "", "Pause");
    this.button.type = "button";
    this.button.addEventListener("click", () => this.toggle());
    this.slider = element("input");
    this.slider.type = "range";
    this.slider.step = "any";
    this.slider.setAttribute("aria-label", "time in the recording");
    this.slider.addEventListener("input", () => {
      this.dragging = true;
    });
    this.slider.addEventListener("change", () => {
      this.dragging = false;
      this.send({ seek: Number(this.slider.value) });
    });
    this.time = element("span");
    this.speed = element("select");
    this.speed.setAttribute("aria-label", "speed");
    for (const value of SPEEDS) this.speed.append(new Option(`${value}×`, value, value === 1, value === 1));
    this.speed.addEventListener("change", () => this.send({ speed: Number(this.speed.value) }));
    const canvas = element("canvas", "marks");
    canvas.setAttribute("role", "img");
    this.marks = new SliderMarks(canvas, () => this.source ?? { start: 0, end: 1 }, go);
    const track = element("div", "track");
    track.append(canvas, this.slider);
    box.append(this.button, track, this.time, this.speed);
  }

  get shown() {
    return this.source !== null && !this.box.hidden;
  }

  toggle() {
    if (!this.source) return;
    this.send({ pause: !this.source.paused });
    this.source = { ...this.source, paused: !this.source.paused }; // until the monitor says so itself
  }

  skip(seconds) {
    if (this.source) this.send({ seek: this.source.t + seconds });
  }

  go(time) {
    if (this.source) this.send({ seek: time });
  }

  show(source) {
    this.box.hidden = source.kind !== "playback";
    if (this.box.hidden) return;
    this.source = source;
    for (const control of [this.button, this.slider, this.speed]) control.disabled = !source.mayAct;
    setText(this.button, source.paused ? "Play" : "Pause");
    this.slider.min = source.start;
    this.slider.max = source.end;
    if (!this.dragging) this.slider.value = source.t;
    this.slider.setAttribute("aria-valuetext", timeOfDay(source.t));
    setText(this.time, `${timeOfDay(source.t)} · ${duration(source.t - source.start)} of ${duration(source.end - source.start)}`);
    if (document.activeElement !== this.speed) this.speed.value = String(source.speed);
  }
}

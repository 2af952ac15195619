// Intruders on the map for as long as their alarms are listed: last place, its age, and the picture.

import { duration } from "./format.js";
import { colour } from "./palette.js";

const NOW = 2.5; // s within which an intruder is seen at present: reports come once a second
const PICTURE = 46; // px, the longer side
const FONT = "600 12px system-ui, 'DejaVu Sans', sans-serif";

export class IntruderMarks {
  // onReady: called when a picture has been loaded.
  constructor(onReady) {
    this.onReady = onReady;
    this.pictures = new Map(); // by URL
  }

  // The pixels that mark, words and picture take, as [x0, y0, x1, y1].
  box(alarm, viewport) {
    const [px, py] = viewport.toPixel(...alarm.place);
    return [px - 65, py - (alarm.picture ? 14 + PICTURE : 11), px + 65, py + 23];
  }

  draw(context, alarm, viewport, wall) {
    const [px, py] = viewport.toPixel(...alarm.place);
    const age = Math.max(wall - alarm.seen, 0);
    this.drawTriangle(context, px, py, age < NOW);
    const words = age < NOW ? "intruder" : `intruder, ${duration(age)} ago`;
    context.font = FONT;
    context.textAlign = "center";
    context.lineWidth = 3.5;
    context.strokeStyle = colour("floor");
    context.strokeText(words, px, py + 19);
    context.fillStyle = colour("critical");
    context.fillText(words, px, py + 19);
    if (alarm.picture) this.drawPicture(context, alarm, px, py);
  }

  // Filled while it is seen, hollow after that.
  drawTriangle(context, px, py, seen) {
    context.beginPath();
    context.moveTo(px, py - 9);
    context.lineTo(px + 8, py + 6);
    context.lineTo(px - 8, py + 6);
    context.closePath();
    context.lineJoin = "round";
    context.strokeStyle = colour("floor");
    context.lineWidth = 5;
    context.stroke();
    context.fillStyle = context.strokeStyle = colour("critical");
    context.lineWidth = 2;
    if (seen) context.fill();
    context.stroke();
  }

  drawPicture(context, alarm, px, py) {
    const picture = this.picture(`/intruder/${alarm.number}?${alarm.picture}`);
    if (!picture.naturalWidth) return;
    const scale = PICTURE / Math.max(picture.naturalWidth, picture.naturalHeight);
    const [width, height] = [picture.naturalWidth * scale, picture.naturalHeight * scale];
    const [left, top] = [px - width / 2, py - 13 - height];
    context.drawImage(picture, left, top, width, height);
    context.strokeStyle = colour("critical");
    context.lineWidth = 1.5;
    context.strokeRect(left, top, width, height);
  }

  picture(url) {
    if (!this.pictures.has(url)) {
      const picture = new Image();
      picture.addEventListener("load", this.onReady);
      picture.src = url;
      this.pictures.set(url, picture);
    }
    return this.pictures.get(url);
  }
}

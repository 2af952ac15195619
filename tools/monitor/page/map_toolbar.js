// The buttons above the map, and what is under the pointer: coordinates, zone, place along the border.

import { setText } from "./element.js";

const find = (id) => document.getElementById(id);

export class MapToolbar {
  constructor(map, border, zones, { fit, follow }) {
    this.map = map;
    this.border = border;
    this.zones = zones;
    this.place = null;
    find("zoom-in").addEventListener("click", () => map.zoom(1.4));
    find("zoom-out").addEventListener("click", () => map.zoom(1 / 1.4));
    find("fit").addEventListener("click", fit);
    find("follow").addEventListener("click", follow);
    find("measure").addEventListener("click", () => this.toggleMeasure());
  }

  toggleMeasure() {
    this.map.toggleMeasure();
    find("measure").setAttribute("aria-pressed", String(this.map.measure.on));
    this.tell(this.place);
  }

  stopMeasure() {
    if (this.map.measure.on) this.toggleMeasure();
  }

  // place: under the pointer, m; null if it is elsewhere.
  tell(place) {
    this.place = place;
    setText(find("place"), [this.map.measure.words(), place ? this.placeWords(place) : ""].filter(Boolean).join(" · "));
  }

  placeWords([x, y]) {
    const near = this.border.nearest(x, y);
    const parts = [`x ${x.toFixed(2)}, y ${y.toFixed(2)} m`, this.zones.nameAt(x, y)];
    if (near) parts.push(`s = ${near.s.toFixed(1)} m, ${near.distance.toFixed(1)} m off`);
    return parts.filter(Boolean).join(" · ");
  }
}

// Zones, named polygons beside the border: drawn corner by corner, named, removed.

export class ZonePanel {
  // zones: [{ name, polygon }], m; elements: button, list; onChange: called after every change.
  constructor(zones, { button, list }, onChange) {
    this.zones = zones;
    this.corners = null; // of the zone being drawn; null: none is
    this.button = button;
    this.list = list;
    this.onChange = onChange;
    button.addEventListener("click", () => (this.corners ? this.finish() : this.begin()));
    this.show();
  }

  get drawing() {
    return this.corners !== null;
  }

  begin() {
    this.corners = [];
    this.changed();
  }

  add(x, y) {
    this.corners.push([x, y]);
    this.changed();
  }

  removeLast() {
    this.corners.pop();
    this.changed();
  }

  cancel() {
    this.corners = null;
    this.changed();
  }

  // Fewer than three corners are no zone.
  finish() {
    const polygon = this.corners;
    this.corners = null;
    if (polygon.length >= 3) this.zones.push({ name: this.freeName(), polygon });
    this.changed();
    if (polygon.length >= 3) this.list.lastElementChild.querySelector("input").select();
  }

  freeName() {
    const names = new Set(this.zones.map((zone) => zone.name));
    let number = 1;
    while (names.has(`zone ${number}`)) number += 1;
    return `zone ${number}`;
  }

  changed() {
    this.show();
    this.onChange();
  }

  show() {
    const count = this.corners?.length ?? 0;
    this.button.textContent = !this.drawing ? "Draw a zone" : count < 3 ? "Give up the zone" : "Close the zone";
    this.button.setAttribute("aria-pressed", String(this.drawing));
    this.list.replaceChildren(...this.zones.map((zone) => this.item(zone)));
  }

  item(zone) {
    const [item, name, remove] = [document.createElement("li"), document.createElement("input"), document.createElement("button")];
    name.value = zone.name;
    name.maxLength = 60;
    name.setAttribute("aria-label", "name of the zone");
    name.addEventListener("input", () => {
      zone.name = name.value;
      this.onChange();
    });
    remove.type = "button";
    remove.textContent = "Remove";
    remove.setAttribute("aria-label", `Remove ${zone.name}`);
    remove.addEventListener("click", () => {
      this.zones.splice(this.zones.indexOf(zone), 1);
      this.changed();
    });
    item.append(name, remove);
    return item;
  }
}

// Switches for the map's layers, kept in the browser's local storage.

const LAYERS = {
  map: ["Walls", true],
  grid: ["Grid", false],
  zones: ["Zones", true],
  border: ["Border", true],
  idleness: ["Time since last visit", false],
  trail: ["Trails", true],
  visibility: ["Visibility range", true],
  scan: ["Laser scan", true],
  particles: ["Particles", true],
  covariance: ["95 % ellipse", true],
  tracks: ["Tracks and strangers", true],
  names: ["Names", true],
};
const KEY = "patrol.layers";

export function makeLayers(box, onChange) {
  const saved = JSON.parse(localStorage.getItem(KEY) ?? "{}");
  const layers = {};
  for (const [name, [words, usual]] of Object.entries(LAYERS)) {
    layers[name] = saved[name] ?? usual;
    const label = document.createElement("label");
    const input = document.createElement("input");
    input.type = "checkbox";
    input.name = name;
    input.checked = layers[name];
    input.addEventListener("change", () => {
      layers[name] = input.checked;
      localStorage.setItem(KEY, JSON.stringify(layers));
      onChange();
    });
    label.append(input, words);
    box.append(label);
  }
  return layers;
}

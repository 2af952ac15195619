// Colours, read from the style sheet once per theme; canvases cannot use its variables.

const ROBOTS = 8;
let cache = new Map();

export function colour(name) {
  if (!cache.has(name)) {
    cache.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  }
  return cache.get(name);
}

export function robotColour(number) {
  return colour(`robot-${number % ROBOTS}`);
}

export function robotVariable(number) {
  return `var(--robot-${number % ROBOTS})`;
}

export function forgetColours() {
  cache = new Map();
}

export function parts(name) {
  const hex = colour(name).slice(1);
  return [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

export function mixed(from, to, share) {
  const [a, b] = [parts(from), parts(to)];
  return `rgb(${a.map((value, index) => Math.round(value + share * (b[index] - value))).join(" ")})`;
}

// Colour of an idleness: blue to yellow to red, by share of the longest shown.
export function idleColour(share) {
  const at = Math.min(Math.max(share, 0), 1);
  return at < 0.5 ? mixed("idle-0", "idle-1", at * 2) : mixed("idle-1", "idle-2", at * 2 - 1);
}

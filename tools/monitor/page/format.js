// Formats numbers, names and times for display.

export const ABSENT = "–";
const LARGEST = 1e6;

export function quantity(value, unit, digits = 2) {
  if (typeof value !== "number" || !Number.isFinite(value)) return ABSENT;
  // Larger numbers are not real and would break the layout.
  const words = Math.abs(value) < LARGEST ? value.toFixed(digits) : value.toExponential(1);
  return unit ? `${words} ${unit}` : words;
}

export function count(value) {
  return typeof value === "number" ? String(value) : ABSENT;
}

export function twist(pair) {
  return pair ? `${quantity(pair[0], "m/s")}, ${quantity(pair[1], "rad/s")}` : ABSENT;
}

const ACTION_NAMES = {
  reach_frontier: "Reach border",
  keep_going: "Keep going",
  patrol_clockwise: "Patrol cw",
  patrol_counter_clockwise: "Patrol ccw",
  avoid_teammate: "Avoid teammate",
};

export function actionName(action) {
  return ACTION_NAMES[action] ?? action;
}

export function timeOfDay(wall) {
  return new Date(wall * 1000).toTimeString().slice(0, 8);
}

// In local time; what is exported tells its zone.
export function dateAndTime(wall) {
  const date = new Date(wall * 1000);
  const two = (value) => String(value).padStart(2, "0");
  return `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())} ${timeOfDay(wall)}`;
}

export function duration(seconds) {
  if (seconds < 90) return `${Math.round(seconds)} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  return `${(seconds / 3600).toFixed(1)} h`;
}

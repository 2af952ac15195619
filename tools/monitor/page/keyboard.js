// Keys of the whole page. A text field, a dialog and a choice keep their own keys.

const OWN_KEYS = "select, input[type=range], input[type=checkbox]";
const BUTTONS = "button, summary, a";

// keys: functions by key; numbers: takes digits; playing: whether a playback is shown, which space pauses
// whatever control has focus.
export function listenToKeys(keys, numbers, playing) {
  document.addEventListener("keydown", (event) => {
    const { target, key } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    if (document.querySelector("dialog[open]") || isText(target)) return;
    if (target.closest?.(OWN_KEYS) && !(key === " " && playing())) return;
    if (target.closest?.(BUTTONS) && (key === "Enter" || (key === " " && !playing()))) return;
    if (numbers.take(key) || !keys[key]) return;
    event.preventDefault();
    keys[key]();
  });
}

function isText(target) {
  return target instanceof HTMLInputElement && !["range", "checkbox"].includes(target.type);
}

// Who acknowledges: a name as typed, kept in the browser's local storage. It proves nothing.

const KEY = "patrol.operator";

export class OperatorName {
  constructor(input) {
    this.input = input;
    input.value = localStorage.getItem(KEY) ?? "";
    input.addEventListener("input", () => localStorage.setItem(KEY, this.value));
  }

  get value() {
    return this.input.value.trim().slice(0, 40);
  }
}

// Choosing a robot by its number: digits typed within a moment are one number, so 12 is no 1 and 2.

const MOMENT_MS = 800;

export class NumberKeys {
  // choose: called with the number as text, at each digit.
  constructor(choose) {
    this.choose = choose;
    this.typed = "";
    this.at = -Infinity;
  }

  // Takes a key; returns whether it was part of a number. A zero begins none.
  take(key) {
    const goesOn = performance.now() - this.at < MOMENT_MS && this.typed !== "";
    if (!/^[0-9]$/.test(key) || (key === "0" && !goesOn)) {
      this.typed = "";
      return false;
    }
    this.typed = (goesOn ? this.typed : "") + key;
    this.at = performance.now();
    this.choose(this.typed);
    return true;
  }
}

// Dark or light: as the system prefers until the operator chooses; remembered on this computer.

import { forgetColours } from "./palette.js";

const KEY = "patrol.theme";

export class Theme {
  constructor(button, onChange) {
    this.button = button;
    this.onChange = onChange;
    this.light = (localStorage.getItem(KEY) ?? (matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark")) === "light";
    this.apply();
    button.addEventListener("click", () => this.toggle());
  }

  toggle() {
    this.light = !this.light;
    localStorage.setItem(KEY, this.light ? "light" : "dark");
    this.apply();
    this.onChange();
  }

  apply() {
    document.documentElement.classList.toggle("light", this.light);
    this.button.textContent = this.light ? "Dark" : "Light";
    forgetColours();
  }
}

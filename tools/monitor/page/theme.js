// Dark or light theme: the system's until chosen, then kept in the browser's local storage.

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

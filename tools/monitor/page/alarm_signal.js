// New alarms as sound and as desktop notifications; each has a switch, kept in the browser's local storage.

const KEYS = { sound: "patrol.sound", notify: "patrol.notify" };
const REPEAT_MS = 10000; // of the sound, while a critical alarm is active and nobody has acknowledged it
const TONES = { critical: [880, 660, 880], warning: [520], info: [] }; // Hz
const TONE_S = 0.16;
const LOUDNESS = 0.12;

export class AlarmSignal {
  constructor(soundButton, notifyButton) {
    this.buttons = { sound: soundButton, notify: notifyButton };
    this.on = {
      sound: localStorage.getItem(KEYS.sound) !== "off",
      notify: localStorage.getItem(KEYS.notify) === "on" && this.mayNotify(),
    };
    this.known = null; // numbers of the alarms that were signalled; null before the first message
    this.soundedAt = -Infinity;
    this.count = 0; // of sounds
    soundButton.addEventListener("click", () => this.set("sound", !this.on.sound));
    notifyButton.addEventListener("click", () => this.switchNotify());
    // A page may sound only after its first click or key.
    for (const kind of ["pointerdown", "keydown"]) document.addEventListener(kind, () => this.wake(), { once: true });
    if (!("Notification" in window)) {
      notifyButton.disabled = true;
      notifyButton.title = "this browser has no notifications for this address";
    }
    this.show();
  }

  mayNotify() {
    return "Notification" in window && Notification.permission === "granted";
  }

  async switchNotify() {
    if (!this.on.notify && !this.mayNotify()) await Notification.requestPermission();
    this.set("notify", !this.on.notify && this.mayNotify());
  }

  set(name, on) {
    this.on[name] = on;
    localStorage.setItem(KEYS[name], on ? "on" : "off");
    this.show();
  }

  show() {
    for (const [name, button] of Object.entries(this.buttons)) button.setAttribute("aria-pressed", String(this.on[name]));
  }

  wake() {
    this.audio ??= new AudioContext();
    this.audio.resume();
  }

  // A monitor that was started again counts its alarms anew.
  forget() {
    this.known = null;
  }

  // Signals the alarms that are new since the last call; of a page just opened the active ones.
  take(alarms, robotName) {
    const active = alarms.filter((alarm) => alarm.cleared === null && !alarm.acknowledged);
    const fresh = active.filter((alarm) => !this.known?.has(alarm.number));
    this.known = new Set(alarms.map((alarm) => alarm.number));
    for (const alarm of fresh) this.notify(alarm, robotName);
    const urgent = active.some((alarm) => alarm.severity === "critical");
    const again = urgent && performance.now() - this.soundedAt > REPEAT_MS;
    if (fresh.length || again) this.sound(urgent ? "critical" : (fresh[0]?.severity ?? "info"));
  }

  notify(alarm, robotName) {
    if (!this.on.notify || alarm.severity === "info") return;
    const name = alarm.robot ? robotName(alarm.robot) : "monitor";
    new Notification(`${name}: ${alarm.text}`, { tag: `patrol ${alarm.robot} ${alarm.kind}` });
  }

  sound(severity) {
    if (!this.on.sound) return;
    this.soundedAt = performance.now();
    this.count += 1;
    if (this.audio?.state !== "running") return;
    TONES[severity].forEach((tone, place) => this.beep(tone, this.audio.currentTime + place * 1.3 * TONE_S));
  }

  beep(tone, at) {
    const [source, gain] = [this.audio.createOscillator(), this.audio.createGain()];
    source.frequency.value = tone;
    gain.gain.setValueAtTime(LOUDNESS, at);
    gain.gain.exponentialRampToValueAtTime(0.001, at + TONE_S);
    source.connect(gain).connect(this.audio.destination);
    source.start(at);
    source.stop(at + TONE_S);
  }
}

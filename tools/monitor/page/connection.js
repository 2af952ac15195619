// The live connection to the monitor; it comes back by itself.

const RETRY_MS = 500;
const SILENT_MS = 3000;

export class Connection {
  constructor(onMessage, onState) {
    this.onMessage = onMessage;
    this.onState = onState;
    this.heardAt = 0;
    this.open();
    setInterval(() => this.checkSilence(), 500);
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/live`);
    let seen = 0;
    this.socket.onmessage = (event) => {
      this.heardAt = performance.now();
      this.onState(true);
      this.onMessage(JSON.parse(event.data));
      // The next ones come only as fast as these are shown: a slow page is behind by one, not more.
      seen += 1;
      const told = seen;
      requestAnimationFrame(() => setTimeout(() => this.send({ seen: told })));
    };
    this.socket.onclose = () => {
      this.onState(false);
      setTimeout(() => this.open(), RETRY_MS);
    };
  }

  checkSilence() {
    if (performance.now() - this.heardAt > SILENT_MS) this.onState(false);
  }

  send(request) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
  }
}

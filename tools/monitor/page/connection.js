// The WebSocket connection to the monitor; reconnects by itself.

const RETRY_MS = 500;
const SILENT_MS = 3000;

export class Connection {
  constructor(onMessage, onState) {
    this.onMessage = onMessage;
    this.onState = onState;
    this.receivedAt = 0;
    this.open();
    setInterval(() => this.checkSilence(), 500);
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/live${location.search}`);
    let seen = 0;
    this.socket.onmessage = (event) => {
      this.receivedAt = performance.now();
      this.onState(true);
      this.onMessage(JSON.parse(event.data));
      // Flow control: the monitor sends on after a frame is drawn, so a slow page is one behind.
      seen += 1;
      const drawn = seen;
      requestAnimationFrame(() => setTimeout(() => this.send({ seen: drawn })));
    };
    this.socket.onclose = () => {
      this.onState(false);
      setTimeout(() => this.open(), RETRY_MS);
    };
  }

  checkSilence() {
    if (performance.now() - this.receivedAt > SILENT_MS) this.onState(false);
  }

  send(request) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
  }
}

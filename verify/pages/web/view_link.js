'use strict';
// The connection: messages as JSON, frames as bytes (docs/view.md).

// { header, parts: [Uint8Array] } of a frame's bytes.
function readFrame(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  let at = 4 + length;
  const parts = header.parts.map(([, bytes]) => {
    const part = new Uint8Array(buffer, at, bytes);
    at += bytes;
    return part;
  });
  return { header, parts };
}

class ViewLink {
  // heard(message), seen(header, bitmaps), changed(text)
  constructor({ heard, seen, changed }) {
    Object.assign(this, { heard, seen, changed });
    this.id = 0;
    this.sentAt = new Map();
    this.shown = 0;
    this.tries = 0;
    this.connect();
  }

  connect() {
    const address = new URL('socket', location.href);
    address.protocol = 'ws:';
    address.hash = '';
    this.socket = new WebSocket(address);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => { this.tries = 0; this.shown = 0; this.changed('connected'); };
    this.socket.onmessage = ({ data }) => {
      if (typeof data === 'string') this.heard(JSON.parse(data));
      else this.show(data);
    };
    this.socket.onclose = () => {
      this.changed('not connected: the program has ended, or the connection is gone');
      this.tries += 1;
      setTimeout(() => this.connect(), Math.min(5000, 250 * 2 ** this.tries));
    };
  }

  get open() { return this.socket.readyState === WebSocket.OPEN; }

  // The number of the message; 0 where nobody listens.
  send(message) {
    if (!this.open) return 0;
    this.id += 1;
    this.sentAt.set(this.id, performance.now());
    if (this.sentAt.size > 1000) this.sentAt.delete(this.sentAt.keys().next().value);
    this.socket.send(JSON.stringify({ ...message, id: this.id }));
    return this.id;
  }

  async show(buffer) {
    const { header, parts } = readFrame(buffer);
    const bitmaps = await Promise.all(parts.map((part) => createImageBitmap(new Blob([part], { type: header.type }))));
    if (header.frame > this.shown) {
      this.shown = header.frame;
      const sent = this.sentAt.get(header.shows);
      if (sent !== undefined) {
        this.latency = performance.now() - sent;
        for (const id of this.sentAt.keys()) if (id <= header.shows) this.sentAt.delete(id);
      }
      this.seen(header, bitmaps);
    }
    if (this.open) this.socket.send('{"type":"seen"}');
  }
}

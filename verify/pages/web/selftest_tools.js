'use strict';
// Shared by the pages' tests of themselves. A page is tested when opened with #selftest at the end of the address.

class SelfTest {
  constructor() {
    this.asked = 0;
    this.failed = [];
  }

  equal(what, found, expected) {
    ++this.asked;
    if (!Object.is(found, expected)) this.failed.push(`${what}: expected ${expected}, found ${found}`);
  }

  write() {
    const verdict = this.failed.length === 0 && this.asked > 0 ? 'passed' : 'FAILED';
    const text = [`selftest: ${verdict}, ${this.asked} asked`, ...this.failed].join('\n');
    document.body.append(element('pre', { id: 'selftest', textContent: text }));
  }
}

function press(key, target = document.body) {
  target.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
}
const addressHas = (key) => new URLSearchParams(location.hash.slice(1)).get(key);

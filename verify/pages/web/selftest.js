'use strict';
// The page's test of itself: open it with #selftest at the end of the address. It drives the viewer as a reader does, by
// keys, pointer and clicks, and compares the page with numbers that it computes itself.

// Reads the page's text anew, not by pixels.js: an integer per float, for the checksums and the values.
function rawWords(base64) {
  const bytes = atob(base64);
  const found = [];
  for (let i = 0; i < bytes.length; i += 4) {
    found.push((bytes.charCodeAt(i) | (bytes.charCodeAt(i + 1) << 8) | (bytes.charCodeAt(i + 2) << 16) | (bytes.charCodeAt(i + 3) << 24)) >>> 0);
  }
  return found;
}
function rawFloat(word) {
  return new Float32Array(Uint32Array.of(word).buffer)[0];
}

function point(type, target, [x, y], side, buttons = 0) {
  const box = target.getBoundingClientRect();
  target.dispatchEvent(new PointerEvent(type, { bubbles: true, buttons, pointerType: 'mouse',
    clientX: box.left + ((x + 0.5) * box.width) / side.width, clientY: box.top + ((y + 0.5) * box.height) / side.height }));
}

const shownView = () => document.querySelector('#views input:checked').value;
const cellText = (row, channel) => document.querySelectorAll('#values tbody tr')[row].cells[1 + channel].textContent;

// The bytes in the middle of a drawn pixel.
function drawn(canvas, [x, y], side) {
  const scale = canvas.width / side.width;
  return [...canvas.getContext('2d').getImageData((x + 0.5) * scale, (y + 0.5) * scale, 1, 1).data].slice(0, 3).join();
}

function testData(test, one, index) {
  for (const plane of Object.keys(one.pixels)) {
    const sum = rawWords(one.pixels[plane]).reduce((all, word) => (all + word) >>> 0, 0);
    test.equal(`${one.name}: checksum of ${plane}`, sum, one.checksums[plane]);
  }
  const thumbnail = document.querySelectorAll('#cases button')[index];
  test.equal(`${one.name}: its button says its verdict`, thumbnail.lastChild.textContent, one.passed ? 'passed' : 'failed');
}

// The worst pixels come from C++ as decimal numbers: they must equal the planes' values and the shown ones.
function testWorst(test, one, raw) {
  const floatOf = (plane, pixel, c) => rawFloat(raw[plane][3 * (pixel.y * one.width + pixel.x) + c]);
  const asShown = (text) => Math.fround(Number(text.replace('∞', 'Infinity')));
  one.worst.forEach((pixel, k) => {
    document.querySelectorAll('#worst button')[k].click();
    test.equal(`${one.name}: worst pixel ${k} in the address`, addressHas('pixel'), `${pixel.x},${pixel.y}`);
    for (let c = 0; c < 3; ++c) {
      const at = `${one.name}: pixel ${pixel.x}, ${pixel.y} channel ${c}`;
      test.equal(`${at}, new as embedded`, floatOf('new', pixel, c), Math.fround(Number(pixel.image[c])));
      test.equal(`${at}, new as shown`, asShown(cellText(0, c)), floatOf('new', pixel, c));
      if (!one.sameSize) continue;
      test.equal(`${at}, golden as embedded`, floatOf('golden', pixel, c), Math.fround(Number(pixel.golden[c])));
      test.equal(`${at}, golden as shown`, asShown(cellText(1, c)), floatOf('golden', pixel, c));
    }
  });
}

// The brightest pixel is amber, the darkest blue. Marks would hide them.
function testHeat(test, one, picture) {
  const z = Array.from({ length: one.z.length / 3 }, (_, i) => largest((c) => one.z[3 * i + c]));
  const finite = z.filter(Number.isFinite);
  viewer.set({ overlay: false });
  for (const [what, extreme] of [['highest', Math.max(...finite)], ['lowest', Math.min(...finite)]]) {
    const i = z.indexOf(extreme);
    const [red, , blue] = drawn(picture, [i % one.width, Math.floor(i / one.width)], one.new).split(',').map(Number);
    test.equal(`${one.name}: the colour of the ${what} z`, red > blue, extreme > 0);
  }
  viewer.set({ overlay: true });
}

function testViews(test, one, picture, middle) {
  const [x, y] = middle;
  const i = y * one.width + x;
  const bytes = (mean) => [0, 1, 2].map((c) => srgbByte(mean[3 * i + c])).join();
  press('1');
  test.equal(`${one.name}: 1 shows new`, shownView(), 'new');
  test.equal(`${one.name}: new is drawn`, drawn(picture, middle, one.new), bytes(one.new.mean));
  press('f');
  test.equal(`${one.name}: F flips to golden`, shownView(), 'golden');
  test.equal(`${one.name}: golden is drawn`, drawn(picture, one.sameSize ? middle : [0, 0], one.golden),
    one.sameSize ? bytes(one.golden.mean) : [0, 1, 2].map((c) => srgbByte(one.golden.mean[c])).join());
  test.equal(`${one.name}: the view is in the address`, addressHas('view'), 'golden');
  press('f');
  test.equal(`${one.name}: F flips back`, shownView(), 'new');
  const flip = document.getElementById('flip');
  flip.dispatchEvent(new PointerEvent('pointerenter'));
  test.equal(`${one.name}: resting on Flip peeks at golden`, shownView(), 'golden');
  flip.dispatchEvent(new PointerEvent('pointerleave'));
  test.equal(`${one.name}: and leaving it ends that`, shownView(), 'new');
  press('6');
  test.equal(`${one.name}: 6 shows z where it is known`, shownView(), one.z ? 'z' : 'new');
  if (one.z) testHeat(test, one, picture);
  press('5');
  test.equal(`${one.name}: 5 shows ulps where sizes are the same`, shownView(), one.sameSize ? 'ulps' : shownView());
  press('1');
}

function testSplit(test, one, picture) {
  if (!one.sameSize) return;
  const slider = document.getElementById('split');
  press('4');
  const row = one.height >> 1;
  const columns = [one.width >> 2, one.width - 1 - (one.width >> 2)];
  const bytes = (mean, x) => [0, 1, 2].map((c) => srgbByte(mean[3 * (row * one.width + x) + c])).join();
  for (const [position, left, right] of [[50, 'new', 'golden'], [100, 'new', 'new'], [0, 'golden', 'golden']]) {
    slider.value = position;
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    test.equal(`${one.name}: split at ${position}, left`, drawn(picture, [columns[0], row], one.new), bytes(one[left].mean, columns[0]));
    test.equal(`${one.name}: split at ${position}, right`, drawn(picture, [columns[1], row], one.new), bytes(one[right].mean, columns[1]));
  }
  point('pointerdown', picture, [one.width / 2 - 0.5, row], one.new, 1);
  test.equal(`${one.name}: the line follows the pointer`, slider.value, '50');
  press('1');
}

function testPixel(test, one, picture, raw) {
  const at = [one.width >> 1, one.height >> 1];
  const i = 3 * (at[1] * one.width + at[0]);
  picture.dispatchEvent(new KeyboardEvent('keydown', { key: 'Home', bubbles: true }));
  point('pointermove', picture, at, one.new);
  test.equal(`${one.name}: the pixel under the cursor`, document.getElementById('place').textContent, at.join(', '));
  test.equal(`${one.name}: its new value`, Math.fround(Number(cellText(0, 1).replace('∞', 'Infinity'))), rawFloat(raw.new[i + 1]));
  const known = (plane) => (raw[plane].length > 0 ? short(rawFloat(raw[plane][i + 1])) : '');
  test.equal(`${one.name}: its variance`, cellText(4, 1), known('new_variance'));
  if (one.sameSize) test.equal(`${one.name}: its z`, cellText(6, 1), known('z'));
  const magnifier = document.getElementById('magnified-new');
  const middle = { width: magnified, height: magnified };
  test.equal(`${one.name}: the middle of the magnifier`, drawn(magnifier, [5, 5], middle),
    [0, 1, 2].map((c) => srgbByte(rawFloat(raw.new[i + c]))).join());
  picture.click();
  point('pointerleave', picture, at, one.new);
  picture.focus();
  viewer.keep(at);
  press('ArrowRight', picture);
  test.equal(`${one.name}: an arrow key moves the pixel`, addressHas('pixel'), `${Math.min(one.width - 1, at[0] + 1)},${at[1]}`);
}

function testOverlay(test, one, picture, raw) {
  const words = raw.new;
  const faulty = [];
  press('1'); // the case before may have left another view
  for (let i = 0; i < words.length; i += 3) {
    if ([0, 1, 2].some((c) => { const v = rawFloat(words[i + c]); return !(v >= 0 && v < Infinity); })) faulty.push(i / 3);
  }
  const said = document.getElementById('count').textContent.split(' ')[0];
  test.equal(`${one.name}: non-finite pixels are counted`, said, String(faulty.length));
  for (const i of faulty.slice(0, 4)) {
    const at = [i % one.width, Math.floor(i / one.width)];
    test.equal(`${one.name}: pixel ${at} is marked`, drawn(picture, at, one.new), '255,45,61');
    press('n');
    test.equal(`${one.name}: and N takes the mark away`, drawn(picture, at, one.new),
      [0, 1, 2].map((c) => srgbByte(rawFloat(words[3 * i + c]))).join());
    press('n');
  }
}

function testAddress(test, one) {
  viewer.set({ view: 'golden', pixel: [1, 2], exposure: -1.5 });
  test.equal(`${one.name}: the case is in the address`, addressHas('case'), one.name);
  const address = location.hash;
  press('1');
  viewer.expose(0);
  viewer.keep([0, 0]);
  history.replaceState(null, '', address);
  viewer.readAddress();
  test.equal(`${one.name}: the address brings back the view`, shownView(), 'golden');
  test.equal(`${one.name}: and the pixel`, document.getElementById('place').textContent, '1, 2');
  test.equal(`${one.name}: and the exposure`, document.getElementById('exposure').value, '-1.5');
  viewer.expose(0);
}

function selfTest() {
  const test = new SelfTest();
  try {
    const picture = document.getElementById('picture');
    (viewer ? viewer.cases : []).forEach((one, index) => {
      document.querySelectorAll('#cases button')[index].click();
      const raw = Object.fromEntries(Object.entries(one.pixels).map(([plane, text]) => [plane, rawWords(text)]));
      testData(test, one, index);
      testWorst(test, one, raw);
      viewer.keep([0, 0]);
      testOverlay(test, one, picture, raw);
      testViews(test, one, picture, [one.width >> 1, one.height >> 1]);
      testSplit(test, one, picture);
      testPixel(test, one, picture, raw);
      testAddress(test, one);
    });
    for (const button of document.querySelectorAll('button.copy')) {
      test.equal('a copy button has a command and a name', button.previousSibling.textContent !== '' && button.hasAttribute('aria-label'), true);
    }
  } catch (error) {
    test.failed.push(String(error.stack ?? error));
  }
  test.write();
}

if (stateFromAddress().selftest !== undefined) selfTest();

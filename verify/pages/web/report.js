'use strict';
// The image viewer: the picture shown, the reader's input, and the address that remembers both.

const captions = {
  new: 'New image, as the eye sees it (sRGB).',
  golden: 'Golden image, as the eye sees it (sRGB).',
  difference: 'Absolute difference, brightened by the exposure: black where both are equal.',
  split: 'New to the left of the line, golden to its right. Drag the line.',
  ulps: 'Distance in float32 units in the last place, largest channel, logarithmic.',
  z: 'In standard deviations, largest channel: blue is darker than golden, amber brighter.',
};
const scales = {
  ulps: { stops: ulpsStops, ticks: ['0', '2⁸', '2¹⁶', '2²⁴', '2³²'] },
  z: { stops: zStops, ticks: ['≤ −6', '−3', '0', '3', '≥ 6'] },
};
const needBoth = ['difference', 'split', 'ulps', 'z'];

class Viewer {
  constructor(root, cases) {
    this.at = Object.fromEntries([...root.querySelectorAll('[id]')].map((e) => [e.id, e]));
    this.root = root;
    this.cases = cases;
    this.state = { index: 0, view: 'new', pixel: [0, 0], exposure: 0, split: 50, overlay: true };
    this.hovered = null; // the pixel under the cursor, which takes precedence over the kept one
    this.peeking = false;
    this.region = null;
    this.fillCases();
    this.listen();
    this.choose(0);
    this.readAddress();
  }

  get one() { return this.cases[this.state.index]; }
  get pixel() { return this.hovered ?? this.state.pixel; }
  get view() { return this.peeking ? (this.state.view === 'golden' ? 'new' : 'golden') : this.state.view; }
  get gain() { return 2 ** this.state.exposure; }

  fillCases() {
    this.cases.forEach((one, index) => {
      const thumbnail = imageCanvas(one.new.width, one.new.height, (i) => viewColor(one, 'new', i, 1));
      const button = element('button', { type: 'button' }, thumbnail, element('span', { textContent: one.name, title: one.name }),
        element('span', { className: one.passed ? 'quiet' : 'fault', textContent: one.passed ? 'passed' : 'failed' }));
      button.addEventListener('click', () => { this.choose(index); this.remember(); });
      this.at.cases.append(button);
    });
  }

  // Chooses another case, and its worst pixel first.
  choose(index) {
    this.state.index = index;
    const worst = this.one.worst[0];
    this.region = this.one.gates.find((gate) => gate.ran && !gate.passed && this.isRegion(gate)) ?? null;
    this.state.pixel = worst ? [worst.x, worst.y] : [this.one.width >> 1, this.one.height >> 1];
    this.hovered = null;
    if (!this.can(this.state.view)) this.state.view = 'new';
    [...this.at.cases.children].forEach((b, k) => b.setAttribute('aria-pressed', String(k === index)));
    this.fillWorst();
    this.fillVerdict();
    this.draw();
  }

  // Whether this is a part of the image, and larger than the pixel that is marked anyway.
  isRegion({ x, y, width, height }) {
    const inside = x + width <= this.one.width && y + height <= this.one.height;
    return inside && width * height > 1 && width * height < this.one.width * this.one.height;
  }

  // A gate's finding, as a button if there is a place to show.
  gateName(gate) {
    if (!gate.ran || !(gate.width > 0) || gate.width === this.one.width) return gate.gate;
    const button = element('button', { type: 'button', textContent: gate.gate, title: `Show ${gate.x}, ${gate.y}` });
    button.addEventListener('click', () => {
      this.region = this.isRegion(gate) ? gate : null;
      this.keep([gate.x + (gate.width >> 1), gate.y + (gate.height >> 1)]);
      this.at.picture.focus();
    });
    return button;
  }

  can(view) {
    if (view === 'z') return this.one.z !== null;
    return this.one.sameSize || !needBoth.includes(view);
  }

  fillWorst() {
    this.at.worst.replaceChildren(...this.one.worst.map((pixel) => {
      const i = pixel.y * this.one.width + pixel.x;
      const button = element('button', { type: 'button', title: `Show pixel ${pixel.x}, ${pixel.y}` },
        element('span', { textContent: `${pixel.x}, ${pixel.y}` }),
        element('span', { textContent: this.one.z ? `z ${short(pixelZ(this.one, i))}` : `${pixelUlps(this.one, i)} ulps` }));
      button.addEventListener('click', () => { this.keep([pixel.x, pixel.y]); });
      return button;
    }));
    if (this.one.worst.length === 0) this.at.worst.append(element('p', { className: 'quiet', textContent: 'None stands out.' }));
  }

  fillVerdict() {
    const rows = this.one.gates.flatMap((gate) => {
      const failed = gate.ran && !gate.passed && !gate.waiver;
      const statistical = gate.ran && ['global', 'tile', 'pixel'].includes(gate.gate);
      const cell = (value) => element('td', { textContent: statistical ? short(number(value)) : '' });
      const row = element('tr', {}, element('th', { scope: 'row' }, this.gateName(gate)), cell(gate.statistic),
        cell(gate.p_value), cell(gate.threshold),
        element('td', { className: failed ? 'fault' : '', textContent: !gate.ran ? 'not asked' : failed ? 'failed' : gate.waiver ? 'waived' : 'passed' }));
      if (gate.text === '') return [row];
      return [row, element('tr', { className: 'why' }, element('td', { colSpan: 5, className: failed ? 'fault' : '', textContent: gate.text }))];
    });
    this.at.gates.tBodies[0].replaceChildren(...rows);
    const { flip, rel_mse, psnr, max_ulps } = this.one.not_judged_by;
    const known = (value, unit) => (Number.isNaN(number(value)) ? 'not known' : short(number(value)) + unit);
    const shown = { FLIP: known(flip, ''), relMSE: known(rel_mse, ''), PSNR: known(psnr, ' dB'), 'largest distance': known(max_ulps, ' ulps') };
    this.at.metrics.replaceChildren(...Object.entries(shown).map(([name, value]) =>
      element('div', {}, element('dt', { textContent: name }), element('dd', { textContent: value }))));
    const say = (text) => element('p', { className: 'quiet', textContent: text });
    const { replay, approve } = this.one;
    this.at.commands.replaceChildren(
      ...(replay ? [say('Render and judge it again'), command(replay, 'judge this image again')] : []),
      ...(approve ? [say('If the new image is right, make it the golden one'), command(approve, 'approve this image')] : []));
  }

  draw() {
    const { one, view, at, state } = this;
    drawPicture(at.picture, one, { view, gain: this.gain, split: state.split / 100, overlay: state.overlay,
      pixel: this.pixel, region: this.region });
    at.picture.setAttribute('aria-label', `${one.name}, ${view}`);
    at.caption.textContent = one.sameSize ? captions[view]
      : `${captions[view]} The sizes differ: new is ${one.new.width} x ${one.new.height}, golden ${one.golden.width} x ${one.golden.height}.`;
    const scale = scales[view];
    at.tone.style.visibility = scale ? 'hidden' : 'visible'; // a heat map has no exposure
    at.heat.style.visibility = scale ? 'visible' : 'hidden';
    if (scale) {
      drawScale(at.scale, scale.stops);
      at.ticks.replaceChildren(...scale.ticks.map((text) => element('span', { textContent: text })));
    }
    for (const input of at.views.querySelectorAll('input')) {
      input.checked = input.value === view;
      input.disabled = !this.can(input.value);
      input.title = input.disabled ? (input.value === 'z' && one.sameSize ? 'The noise is not known.' : 'The sizes differ.') : '';
    }
    at.split.value = state.split;
    at.split.disabled = view !== 'split';
    at.share.textContent = `${state.split} %`;
    at.exposure.value = state.exposure;
    at.stops.textContent = `${state.exposure < 0 ? '−' : '+'}${Math.abs(state.exposure).toFixed(2)} EV`;
    at.overlay.checked = state.overlay;
    const faults = (side) => { let n = 0; for (let i = 0; i < side.width * side.height; ++i) n += faultyPixel(side.mean, i); return n; };
    const [inNew, inGolden] = [faults(one.new), faults(one.golden)];
    at.count.textContent = inGolden === 0 ? String(inNew) : `${inNew} + ${inGolden}`;
    at.count.className = inNew + inGolden > 0 ? 'number fault' : 'number';
    at.count.title = `${inNew} in the new image, ${inGolden} in the golden image`;
    this.drawPixel();
  }

  drawPixel() {
    const { one, at, pixel } = this;
    drawMagnifier(at['magnified-new'], one.new, this.gain, this.state.overlay, pixel);
    drawMagnifier(at['magnified-golden'], one.golden, this.gain, this.state.overlay, pixel);
    at.place.textContent = `${pixel[0]}, ${pixel[1]}`;
    const value = (plane, side) => (c) => {
      const inside = plane && pixel[0] < side.width && pixel[1] < side.height;
      return inside ? plane[3 * (pixel[1] * side.width + pixel[0]) + c] : undefined;
    };
    const a = value(one.new.mean, one.new);
    const b = value(one.golden.mean, one.golden);
    const va = value(one.new.variance, one.new);
    const vb = value(one.golden.variance, one.golden);
    const of = (f, ...needed) => (c) => (needed.some((n) => n(c) === undefined) ? '' : f(...needed.map((n) => n(c))));
    const rows = {
      new: of(shortest, a), golden: of(shortest, b), difference: of((x, y) => short(x - y), a, b),
      ulps: of((x, y) => String(ulpsApart(x, y)), a, b),
      'variance, new': of(short, va), 'variance, golden': of(short, vb),
      z: of(short, value(one.z, one.new)),
    };
    at.values.tBodies[0].replaceChildren(...Object.entries(rows).map(([name, cell]) =>
      element('tr', {}, element('th', { scope: 'row', textContent: name }),
        ...[0, 1, 2].map((c) => element('td', { textContent: cell(c) })))));
    this.one.worst.forEach((worst, k) => {
      at.worst.children[k].setAttribute('aria-pressed', String(worst.x === pixel[0] && worst.y === pixel[1]));
    });
  }

  set(change) {
    Object.assign(this.state, change);
    this.draw();
    this.remember();
  }

  keep(pixel) {
    const { width, height } = shownSide(this.one, this.view);
    this.hovered = null;
    this.set({ pixel: [Math.min(width - 1, Math.max(0, pixel[0])), Math.min(height - 1, Math.max(0, pixel[1]))] });
  }

  hover(pixel) {
    if (String(pixel) === String(this.hovered)) return;
    this.hovered = pixel;
    this.drawPixel();
  }

  peek(on) {
    if (this.peeking === on) return;
    this.peeking = on;
    this.draw();
  }

  show(view) { if (this.can(view)) this.set({ view }); }
  flip() { this.set({ view: this.state.view === 'new' ? 'golden' : 'new' }); }
  expose(exposure) { this.set({ exposure: Math.min(8, Math.max(-8, exposure)) }); }

  // The address keeps everything that differs from the beginning.
  remember() {
    const { view, pixel, exposure, split, overlay } = this.state;
    stateToAddress({ case: this.one.name, view, pixel: pixel.join(','), exposure: exposure || undefined,
      split: split === 50 ? undefined : split, overlay: overlay ? undefined : 'off' });
  }

  readAddress() {
    const found = stateFromAddress();
    const index = this.cases.findIndex((one) => one.name === found.case);
    if (index < 0) return;
    if (index !== this.state.index) this.choose(index);
    const within = (text, low, high, otherwise) => {
      const value = text === undefined || text === '' ? NaN : Number(text);
      return Number.isFinite(value) ? Math.min(high, Math.max(low, value)) : otherwise;
    };
    const side = this.one.new;
    const [x, y] = (found.pixel ?? '').split(',');
    this.state.pixel = [Math.floor(within(x, 0, side.width - 1, this.state.pixel[0])), Math.floor(within(y, 0, side.height - 1, this.state.pixel[1]))];
    this.state.exposure = within(found.exposure, -8, 8, 0);
    this.state.split = within(found.split, 0, 100, 50);
    this.state.overlay = found.overlay !== 'off';
    this.state.view = Object.hasOwn(captions, found.view ?? '') && this.can(found.view) ? found.view : 'new';
    this.draw();
    this.root.scrollIntoView();
  }

  pixelAt(event) {
    const box = this.at.picture.getBoundingClientRect();
    const { width, height } = shownSide(this.one, this.view);
    const along = (position, size, count) => Math.min(count - 1, Math.max(0, Math.floor((position / size) * count)));
    return [along(event.clientX - box.left, box.width, width), along(event.clientY - box.top, box.height, height)];
  }

  listen() {
    const { at } = this;
    at.views.addEventListener('change', (event) => this.show(event.target.value));
    at.exposure.addEventListener('input', () => this.expose(Number(at.exposure.value)));
    at.split.addEventListener('input', () => this.set({ split: Number(at.split.value) }));
    at.overlay.addEventListener('change', () => this.set({ overlay: at.overlay.checked }));
    at.flip.addEventListener('pointerenter', () => this.peek(true));
    at.flip.addEventListener('pointerdown', () => this.peek(true));
    for (const end of ['pointerleave', 'pointercancel', 'blur']) at.flip.addEventListener(end, () => this.peek(false));
    at.flip.addEventListener('pointerup', (event) => { if (event.pointerType !== 'mouse') this.peek(false); });
    at.flip.addEventListener('click', (event) => { if (event.detail === 0) this.flip(); }); // by keyboard
    this.listenToPicture(at.picture);
    document.addEventListener('keydown', (event) => this.key(event));
    addEventListener('hashchange', () => this.readAddress());
  }

  listenToPicture(picture) {
    const dragSplit = (event) => {
      const box = picture.getBoundingClientRect();
      const share = (event.clientX - box.left) / box.width;
      this.set({ split: Math.round(100 * Math.min(1, Math.max(0, share))) });
    };
    const dragging = (event) => this.view === 'split' && (event.buttons & 1) === 1;
    picture.addEventListener('pointermove', (event) => {
      if (dragging(event)) dragSplit(event);
      this.hover(this.pixelAt(event));
    });
    picture.addEventListener('pointerdown', (event) => { if (dragging(event)) dragSplit(event); });
    picture.addEventListener('pointerleave', () => { this.hovered = null; this.drawPixel(); });
    picture.addEventListener('click', (event) => { if (this.view !== 'split') this.keep(this.pixelAt(event)); });
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const move = arrows[event.key];
    if (move && event.target === this.at.picture) {
      event.preventDefault();
      this.keep([this.state.pixel[0] + move[0], this.state.pixel[1] + move[1]]);
      return;
    }
    const view = Object.keys(captions)[Number(event.key) - 1];
    if (view) this.show(view);
    else if (event.key === 'f' || event.key === 'F') this.flip();
    else if (event.key === 'n' || event.key === 'N') this.set({ overlay: !this.state.overlay });
    else if (event.key === '+' || event.key === '=') this.expose(this.state.exposure + 0.25);
    else if (event.key === '-' || event.key === '−') this.expose(this.state.exposure - 0.25);
  }
}

let viewer = null;
const imageData = document.getElementById('image-data');
if (imageData) viewer = new Viewer(document.getElementById('images'), JSON.parse(imageData.textContent).map(decodeCase));

'use strict';
// Launches in order, coloured by verdict, and the lengths of their queues: traversals beside each other, levels below.

// The style sheet's colours, for canvases; they change with light and dark.
function inks() {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(['paper', 'panel', 'line', 'ink', 'quiet', 'accent', 'fault', 'mono'].map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}
const bytesOf = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
const mix = (from, to, share) => `rgb(${bytesOf(from).map((c, i) => Math.round(c + share * (bytesOf(to)[i] - c)))})`;

// A canvas of that many CSS pixels, sharp on any display.
function fitted(canvas, height, width = canvas.clientWidth) {
  const scale = devicePixelRatio || 1;
  canvas.style.height = `${height}px`;
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  const context = canvas.getContext('2d');
  context.scale(scale, scale);
  context.clearRect(0, 0, width, height);
  return context;
}
const pointIn = (canvas, event) => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };

const traversalName = (launch, short = false) => {
  if (launch.bounce === null) return 'image';
  const path = short ? `b${launch.bounce}` : `bounce ${launch.bounce}`;
  return launch.light === null ? path : `${path} ${short ? 'l' : 'light '}${launch.light}`;
};

class Timeline {
  constructor(at, page, selection) {
    Object.assign(this, { canvas: at.timeline, note: at['time-note'], page, selection, height: 86, top: 20, base: 74 });
    this.entries = page.launches.map((launch) => {
      const counts = page.pool.get(launch.counts);
      return counts ? counts.reduce((all, count) => all + count, 0) : 0;
    });
    this.most = Math.max(1, ...this.entries);
    this.canvas.addEventListener('click', (event) => selection.select({ launch: this.launchAt(pointIn(this.canvas, event)[0]) }));
    this.canvas.addEventListener('pointermove', (event) => { this.canvas.title = this.title(this.launchAt(pointIn(this.canvas, event)[0])); });
  }
  get step() { return this.canvas.clientWidth / this.page.launches.length; }
  launchAt(x) { return Math.min(this.page.launches.length - 1, Math.max(0, Math.floor(x / this.step))); }
  title(k) {
    const launch = this.page.launches[k];
    const said = [`${launch.launch} ${launch.name}`];
    if (isLevelKernel(launch)) said.push(`${this.entries[k]} entries`);
    if (launch.verdict) said.push(launch.verdict);
    const broken = [...new Set([...launch.invariants.a, ...launch.invariants.b].map((f) => f.name))];
    if (broken.length > 0) said.push(broken.join(', '));
    return said.join('\n');
  }
  color(k, ink) {
    const launch = this.page.launches[k];
    if (this.page.failed(k)) return ink.fault;
    if (launch.verdict === 'reordered') return mix(ink.panel, ink.accent, 0.45);
    return mix(ink.panel, ink.accent, 0.75);
  }
  draw() {
    const { canvas, page, selection, step, top, base } = this;
    const context = fitted(canvas, this.height);
    const ink = inks();
    const room = base - top - 4;
    page.launches.forEach((launch, k) => {
      const x = k * step;
      const queues = isLevelKernel(launch);
      const height = queues ? 8 + (room - 8) * Math.log2(1 + this.entries[k]) / Math.log2(1 + this.most) : 4;
      context.globalAlpha = page.embedded(k) ? 1 : 0.35;
      context.fillStyle = queues || page.failed(k) ? this.color(k, ink) : mix(ink.paper, ink.quiet, 0.45);
      context.fillRect(x, base - height, Math.max(1, step - (step > 3 ? 1 : 0.25)), height);
    });
    context.globalAlpha = 1;
    this.drawNames(context, ink);
    const x = (selection.launch + 0.5) * step;
    context.fillStyle = ink.ink;
    context.fillRect(x - 0.75, top - 2, 1.5, base - top + 4);
    context.beginPath();
    context.moveTo(x, base + 3); context.lineTo(x - 5, base + 11); context.lineTo(x + 5, base + 11);
    context.fill();
    const failed = page.launches.filter((_, k) => page.failed(k)).length;
    this.note.textContent = `${page.launches.length} launches${failed > 0 ? `, ${failed} in red` : ''}; the height is the length of all queues, logarithmic`;
  }
  drawNames(context, ink) {
    const { page, step } = this;
    context.font = '12px system-ui, sans-serif';
    context.textBaseline = 'middle';
    let begin = 0;
    const place = ({ batch, bounce, light }) => `${batch} ${bounce} ${light}`;
    page.launches.forEach((launch, k) => {
      const next = page.launches[k + 1];
      if (next && place(next) === place(launch)) return;
      const width = (k + 1 - begin) * step;
      const name = traversalName(launch);
      context.fillStyle = ink.line;
      if (begin > 0) context.fillRect(begin * step - 0.75, 4, 1, this.base - 4);
      context.fillStyle = ink.quiet;
      const text = [page.batches > 1 ? `batch ${launch.batch} ${name}` : name, name, traversalName(launch, true)].find((t) => context.measureText(t).width + 6 < width);
      if (text && k > begin) context.fillText(text, begin * step + 3, 10);
      begin = k + 1;
    });
  }
}

// Columns are traversals, rows are levels; a cell shows the nodes of its level from left to right.
class Heat {
  constructor(at, page, selection) {
    Object.assign(this, { canvas: at.heat, note: at['heat-note'], kind: at['heat-kind'], page, selection, row: 19, top: 20, left: 22 });
    this.columns = [];
    page.launches.forEach((launch, k) => {
      if (!isLevelKernel(launch)) return;
      const key = `${launch.batch} ${launch.bounce} ${launch.light}`;
      let column = this.columns.find((c) => c.key === key);
      if (!column) this.columns.push(column = { key, first: launch, launches: [] });
      column.launches[launch.level] = k;
    });
    this.most = Math.max(1, ...page.launches.map((l) => Math.max(0, ...page.pool.get(l.counts) ?? [])));
    this.kind.hidden = !page.runs.b;
    this.kind.addEventListener('change', (event) => selection.select({ heat: event.target.value }, false));
    this.canvas.addEventListener('click', (event) => { const found = this.find(event); if (found) selection.select(found); });
    this.canvas.addEventListener('pointermove', (event) => { this.canvas.title = this.title(this.find(event)); });
  }
  get cell() { return (this.canvas.clientWidth - this.left) / Math.max(1, this.columns.length); }
  bins(nodes) { return Math.max(1, Math.min(nodes, Math.floor((this.cell - 3) / 2))); }

  find(event) {
    const [x, y] = pointIn(this.canvas, event);
    const column = this.columns[Math.floor((x - this.left) / this.cell)];
    const launch = column?.launches[Math.floor((y - this.top) / this.row)];
    if (launch === undefined) return null;
    const values = this.values(launch);
    const bins = this.bins(values.length);
    const inside = (x - this.left) % this.cell / (this.cell - 3);
    const bin = Math.min(bins - 1, Math.max(0, Math.floor(inside * bins)));
    const [from, to] = [bin, bin + 1].map((b) => Math.floor((b * values.length) / bins));
    let most = from;
    for (let i = from; i < to; ++i) if (values[i] > values[most]) most = i;
    return { launch, node: this.page.tree.levelBegins[this.page.launches[launch].level] + most };
  }
  title(found) {
    if (!found) return '';
    const launch = this.page.launches[found.launch];
    const at = found.node - this.page.tree.levelBegins[launch.level];
    const differences = this.page.pool.get(launch.differences);
    return `${launch.name}, node ${found.node}: ${this.page.pool.get(launch.counts)[at]} entries${differences?.[at] ? `, ${differences[at]} differ` : ''}`;
  }
  values(k) {
    const launch = this.page.launches[k];
    const counts = this.selection.run.counts(k) ?? this.page.runs.a.counts(k);
    return this.selection.heat === 'differences' ? this.page.pool.get(launch.differences) ?? new Uint32Array(counts.length) : counts;
  }
  draw() {
    const { canvas, page, selection, row, top, left, cell } = this;
    const context = fitted(canvas, top + row * page.tree.levels + 2);
    const ink = inks();
    const differences = selection.heat === 'differences';
    context.font = '12px system-ui, sans-serif';
    context.textBaseline = 'middle';
    for (let level = 0; level < page.tree.levels; ++level) {
      context.fillStyle = ink.quiet;
      context.fillText(String(level), 2, top + (level + 0.5) * row);
    }
    this.columns.forEach((column, c) => {
      const x = left + c * cell;
      context.fillStyle = ink.quiet;
      const name = [traversalName(column.first), traversalName(column.first, true)].find((t) => context.measureText(t).width < cell - 2);
      if (name) context.fillText(name, x, 9);
      column.launches.forEach((k, level) => this.drawCell(context, ink, k, x, top + level * row, cell - 3, row - 3, differences));
    });
    for (const input of this.kind.querySelectorAll('input')) input.checked = input.value === selection.heat;
    this.note.textContent = differences ? 'Nodes in order from left to right. Red: entries missing, extra or changed.'
      : `Nodes in order from left to right, the longest queue of neighbours: up to ${this.most} entries, logarithmic.`;
  }
  drawCell(context, ink, k, x, y, width, height, differences) {
    const { page, selection } = this;
    const counts = selection.run.counts(k) ?? page.runs.a.counts(k);
    const values = this.values(k);
    const bins = this.bins(values.length);
    for (let bin = 0; bin < bins; ++bin) {
      let [most, entries] = [0, 0];
      for (let i = Math.floor((bin * values.length) / bins); i < Math.floor(((bin + 1) * values.length) / bins); ++i) {
        most = Math.max(most, values[i]);
        entries = Math.max(entries, counts[i]);
      }
      const share = Math.log2(1 + entries) / Math.log2(1 + this.most);
      context.fillStyle = differences && most > 0 ? ink.fault : mix(ink.panel, differences ? ink.quiet : ink.accent, differences ? 0.3 * share : share);
      context.fillRect(x + (bin * width) / bins, y, width / bins + 0.3, height);
    }
    if (selection.launch !== k) return;
    context.strokeStyle = ink.ink;
    context.lineWidth = 1.5;
    context.strokeRect(x - 1, y - 1, width + 2, height + 2);
    if (selection.shown === null) return;
    const at = (selection.shown - page.tree.levelBegins[page.launches[k].level] + 0.5) / values.length;
    context.fillStyle = ink.ink;
    context.fillRect(x + at * width - 1, y - 3, 2, 4);
  }
}

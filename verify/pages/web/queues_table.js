'use strict';
// The entries of a queue, both runs aligned: only the visible rows are made.

const rowHeight = 26; // as in queues.css
const fields = ['origin x', 'origin y', 'origin z', 't min', 'direction x', 'direction y', 'direction z', 't max'];
const fieldOrder = [0, 1, 2, 4, 5, 6, 3, 7];

class QueuePane {
  constructor(at, page, selection) {
    Object.assign(this, { box: at.queue, note: at['queue-note'], kind: at['float-kind'], page, selection, rows: [] });
    this.body = this.box.querySelector('tbody');
    this.kind.addEventListener('change', (event) => selection.select({ float: event.target.value }, false));
    this.box.addEventListener('scroll', () => this.drawRows());
    this.body.addEventListener('click', (event) => {
      const row = event.target.closest('tr[data-ray]');
      if (row) selection.select({ ray: Number(row.dataset.ray) });
    });
  }

  // A row is { a, b, change, what }: positions, null if that run has none.
  makeRows() {
    const { page, selection } = this;
    const node = selection.shown;
    const pairs = page.pairs(selection.launch, node);
    if (pairs) return pairs.map((pair) => ({ ...pair, a: pair.a < 0 ? null : pair.a, b: pair.b < 0 ? null : pair.b }));
    return Array.from({ length: page.runs.a.length(selection.launch, node) }, (_, i) => ({ a: i, b: i, change: 'same', what: 0 }));
  }
  entry(side, position) {
    const { page, selection } = this;
    const run = page.runs[side];
    if (position === null || !run) return null;
    const ray = run.ray(selection.launch, selection.shown, position);
    return { ray, ...run.place(selection.launch, selection.shown, position), record: run.record(selection.launch, ray), minimum: run.minimum(selection.launch, ray) };
  }

  draw() {
    const { page, selection, box } = this;
    for (const input of this.kind.querySelectorAll('input')) input.checked = input.value === selection.float;
    const shown = selection.shown !== null && selection.embedded && page.runs.a.index(selection.launch);
    this.rows = shown ? this.makeRows() : [];
    box.hidden = !shown;
    if (!shown) {
      this.note.textContent = !selection.hasQueues ? `${selection.at.kind} reads no queues.` : 'Its entries are not embedded.';
      return;
    }
    const length = `${this.rows.length} ${this.rows.length === 1 ? 'entry' : 'entries'}`;
    const count = (change) => this.rows.filter((row) => row.change === change).length;
    const said = changes.slice(1).map((change) => [count(change), change]).filter(([n]) => n > 0).map(([n, change]) => `${n} ${change}`);
    this.note.textContent = `of node ${selection.shown} in ${selection.at.name}: ${length}${said.length > 0 ? `; in B ${said.join(', ')}` : ''}`;
    this.columns = this.makeColumns();
    box.querySelector('thead').replaceChildren(element('tr', {}, ...this.columns.map(([name]) => element('th', { scope: 'col', textContent: name }))));
    this.drawRows(); // gives the box its height
    this.showSelected();
    this.drawRows();
  }
  makeColumns() {
    const two = this.page.runs.b !== undefined;
    const float = (value) => (value === null || value === undefined ? '' : this.selection.float === 'hex' ? hexFloat(value) : shortest(value));
    const differing = (a, b) => (a !== undefined && b !== undefined && !Object.is(a, b) ? ` ${ulpsApart(a, b) > 0 ? '+' : ''}${ulpsApart(a, b)} ulps` : '');
    const of = (get) => ({ a, b }) => { const [x, y] = [a && get(a), b && get(b)]; return x === null || x === undefined ? y ?? '' : x; };
    const floats = (get) => ({ a, b }) => {
      const [x, y] = [a ? get(a) : undefined, b ? get(b) : undefined];
      return [float(x ?? y), x !== undefined && y !== undefined && x !== null && y !== null ? differing(x, y) : ''];
    };
    const from = (entry) => { const p = this.page.fromPixel(this.selection.at.batch, entry.ray); return p ? `${p.x}, ${p.y}${p.sample > 0 ? ` #${p.sample}` : ''}` : ''; };
    return [...(two ? [['', ({ change }) => (change === 'same' ? '' : change)]] : []),
      [two ? 'A' : 'entry', ({ row }) => row.a ?? '–'], ...(two ? [['B', ({ row }) => row.b ?? '–']] : []),
      ['block', of((e) => e.block)], ['thread', of((e) => e.thread)], ['ray', of((e) => e.ray)], ['pixel', of(from)],
      ...fieldOrder.map((f) => [fields[f], floats((e) => e.record?.[f])]), ['minimum', floats((e) => e.minimum)]];
  }
  showSelected() {
    const at = this.rows.findIndex((row) => this.rayOf(row) === this.selection.ray);
    const key = `${this.selection.launch} ${this.selection.shown} ${at}`;
    if (key === this.shownKey) return; // scrolling stays as it is
    this.shownKey = key;
    const top = at * rowHeight;
    if (at < 0) this.box.scrollTop = 0;
    else if (top < this.box.scrollTop || top > this.box.scrollTop + this.box.clientHeight - 3 * rowHeight) this.box.scrollTop = Math.max(0, top - 3 * rowHeight);
  }
  rayOf(row) { return row.a !== null ? this.page.runs.a.ray(this.selection.launch, this.selection.shown, row.a) : this.page.runs.b.ray(this.selection.launch, this.selection.shown, row.b); }

  drawRows() {
    if (this.rows.length === 0 || this.box.hidden) { this.body.replaceChildren(); return; }
    const first = Math.max(0, Math.floor(this.box.scrollTop / rowHeight) - 4);
    const last = Math.min(this.rows.length, first + Math.ceil(this.box.clientHeight / rowHeight) + 8);
    const spacer = (rows) => element('tr', { className: 'spacer', 'aria-hidden': 'true' },
      element('td', { colSpan: this.columns.length, style: `height: ${rows * rowHeight}px` }));
    const made = [];
    for (let i = first; i < last; ++i) made.push(this.makeRow(this.rows[i]));
    this.body.replaceChildren(spacer(first), ...made, spacer(this.rows.length - last));
  }
  makeRow(row) {
    const ray = this.rayOf(row);
    const cells = { row, change: row.change, a: this.entry('a', row.a), b: this.entry('b', row.b) };
    const inPixel = this.selection.pixelRays.has(ray);
    const made = element('tr', { 'data-ray': String(ray), 'aria-selected': String(ray === this.selection.ray), className: `${row.change}${inPixel ? ' pixel' : ''}` });
    for (const [, text] of this.columns) {
      const said = text(cells);
      const [value, more] = Array.isArray(said) ? said : [said, ''];
      const cell = element('td', { textContent: String(value) });
      if (more) cell.append(element('span', { className: 'fault', textContent: more }));
      made.append(cell);
    }
    return made;
  }
}

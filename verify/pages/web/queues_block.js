'use strict';
// One thread block: which of its rays go to which child, their scan, and the reserved room.

class BlockPane {
  constructor(at, page, selection) {
    Object.assign(this, { box: at.block, note: at['block-note'], key: at['block-key'], page, selection, row: 24, top: 30, left: 76 });
    this.canvas = element('canvas', { tabIndex: 0, 'aria-label': 'Threads of the block, and what they push' });
    this.box.append(this.canvas);
    this.canvas.addEventListener('pointermove', (event) => { this.canvas.title = this.title(...pointIn(this.canvas, event)); });
    this.canvas.addEventListener('click', (event) => {
      const thread = this.threadAt(pointIn(this.canvas, event)[0]);
      if (this.block?.rays[thread] !== undefined) selection.select({ ray: this.block.rays[thread] });
    });
  }

  // Finds the block of the selected entry, or the node's first.
  find() {
    const { selection } = this;
    const { run, launch, shown, page } = selection;
    const index = selection.embedded && shown !== null ? run.index(launch) : null;
    const length = index ? run.length(launch, shown) : 0;
    if (length === 0 || run.get(launch, 'places')) return null; // a block of pairs is of several nodes
    const { threads } = selection.at;
    const at = run.nodesWith(launch, selection.ray).find(({ node }) => node === shown)?.position ?? 0;
    const begin = Math.floor(at / threads) * threads;
    const count = Math.min(threads, length - begin);
    const visits = Array.from({ length: count }, (_, t) => visitDocument(run, launch, shown, begin + t));
    return { number: run.place(launch, shown, at).block, begin, count, threads, length, visits, chosen: at - begin,
      rays: visits.map((_, t) => run.ray(launch, shown, begin + t)), of: Math.ceil(length / threads), rows: this.rows(page, run, launch, visits) };
  }
  rows(page, run, launch, visits) {
    if (visits[0].leaf) {
      return [{ name: 'triangles', hit: visits.map((v) => v.leaf.outcome !== 'no hit'), text: visits.map((v) => (v.leaf.hits[0] ? String(v.leaf.hits[0].slot) : '')),
        say: visits.map((v) => `${v.leaf.outcome}${v.leaf.hits[0] ? `, slot ${v.leaf.hits[0].slot}` : ''}`) }];
    }
    const below = page.launches[launch].level + 1;
    return visits[0].children.map(({ node }, c) => {
      const places = visits.map((v) => v.children[c].position);
      const pushed = places.filter((place) => place !== null);
      const base = pushed.length > 0 ? Math.min(...pushed) : null;
      const at = node - page.tree.levelBegins[below];
      const offset = run.get(launch, 'child_offsets')?.[at] ?? null;
      const bad = visits.map((v) => v.children[c].outcome === 'lost' || v.children[c].outcome === 'extra');
      return { name: `child ${node}`, node, hit: places.map((place) => place !== null), bad, text: places.map((place) => (place === null ? '' : String(place - base))),
        say: visits.map((v, t) => (places[t] === null ? v.children[c].outcome : `${v.children[c].outcome}: entry ${places[t]} = ${base} + ${places[t] - base}`)),
        base, count: pushed.length, offset, claimed: run.get(launch, 'child_claimed')?.[at], room: run.get(launch, 'child_room')?.[at] };
    });
  }

  get cell() { return Math.max(4, Math.min(22, (this.box.clientWidth - this.left - 206) / this.block.threads)); }
  threadAt(x) { return this.block ? Math.floor((x - this.left) / this.cell) : -1; }
  title(x, y) {
    const thread = this.threadAt(x);
    const row = this.block?.rows[Math.floor((y - this.top) / this.row)];
    if (!this.block || thread < 0 || thread >= this.block.count) return '';
    return `thread ${thread}, ray ${this.block.rays[thread]}${row ? `\n${row.name}: ${row.say[thread]}` : ''}`;
  }

  draw() {
    const { selection, box, canvas } = this;
    this.block = this.find();
    box.hidden = this.key.hidden = this.block === null;
    if (!this.block) {
      this.note.textContent = selection.shown === null ? '' : selection.embedded ? 'The queue is empty: no block has it.' : 'Not embedded.';
      return;
    }
    const { block } = this;
    this.note.textContent = `${block.number}: entries ${block.begin} to ${block.begin + block.count - 1} of node ${selection.shown}, ${block.count} of ${block.threads} threads at work; the node has ${block.of} block${block.of === 1 ? '' : 's'}`;
    const leaf = block.rows[0].base === undefined;
    this.key.textContent = leaf ? 'A cell is a thread whose ray meets a triangle; the number is the slot of the ray’s buffer.'
      : 'A filled cell is a push: the scan’s input. The number is where in the reservation it went: the scan’s result. The reservation is what one atomicAdd gave the block in the child’s queue.';
    const width = Math.max(this.left + block.threads * this.cell + (leaf ? 0 : 206), 300);
    canvas.style.width = `${width}px`;
    const context = fitted(canvas, this.top + block.rows.length * this.row + 4, width);
    this.paint(context, inks(), leaf);
  }
  paint(context, ink, leaf) {
    const { block, left, top, row, cell } = this;
    context.textBaseline = 'middle';
    context.font = '12px system-ui, sans-serif';
    context.fillStyle = ink.quiet;
    context.fillText('thread', 0, 12);
    for (let t = 0; t < block.threads; t += 8) context.fillText(String(t), left + t * cell, 12);
    const end = left + block.threads * cell + 14;
    if (!leaf) { context.fillText('rays', end, 12); context.fillText('reserved, of all', end + 44, 12); }
    block.rows.forEach((one, r) => {
      const y = top + r * row;
      context.font = '12px system-ui, sans-serif';
      context.fillStyle = ink.ink;
      context.fillText(one.name, 0, y + row / 2 - 1);
      for (let t = 0; t < block.threads; ++t) this.paintCell(context, ink, one, t, left + t * cell, y);
      if (leaf) return;
      context.font = `12px ${ink.mono}`;
      context.fillStyle = one.count > 0 ? ink.ink : ink.quiet;
      context.fillText(String(one.count), end, y + row / 2 - 1);
      const claimed = `${one.claimed ?? '?'}`;
      context.fillText(one.base === null ? `none of ${claimed}` : `[${one.base}, ${one.base + one.count}) of ${claimed}`, end + 44, y + row / 2 - 1);
    });
    context.strokeStyle = ink.ink;
    context.lineWidth = 1.5;
    context.strokeRect(left + block.chosen * cell - 0.5, top - 3, cell, block.rows.length * row + 2);
  }
  paintCell(context, ink, one, t, x, y) {
    const { block, cell, row } = this;
    const there = t < block.count;
    context.fillStyle = !there ? ink.paper : one.bad?.[t] ? ink.fault : one.hit[t] ? mix(ink.panel, ink.accent, 0.75) : ink.panel;
    context.fillRect(x, y, Math.max(1, cell - 1), row - 4);
    if (!there || one.text[t] === '' || cell < 13) return;
    context.font = `${cell < 16 ? 9 : 10}px ${ink.mono}`;
    context.fillStyle = ink.paper;
    context.textAlign = 'center';
    context.fillText(one.text[t], x + (cell - 1) / 2, y + (row - 4) / 2 + 0.5);
    context.textAlign = 'left';
  }
}

'use strict';
// The selected node with its ancestors, neighbours and children, each with its queue as a bar.

class TreePane {
  constructor(at, page, selection) {
    Object.assign(this, { list: at.tree, note: at['tree-note'], page, selection });
    this.list.addEventListener('click', (event) => {
      const row = event.target.closest('[data-node]');
      if (row) selection.select({ node: Number(row.dataset.node) });
    });
  }

  get launches() { return this.page.traversal(this.selection.launch); }
  launchOf(level) { return this.launches.find((k) => this.page.launches[k].level === level); }
  // Null if the level was not captured.
  count(node, run) {
    const { tree } = this.page;
    const level = tree.level(node);
    const k = this.launchOf(level);
    return k === undefined ? null : run.counts(k)?.[node - tree.levelBegins[level]] ?? null;
  }
  differs(node) {
    const { tree, launches, pool } = this.page;
    const level = tree.level(node);
    const k = this.launchOf(level);
    return k === undefined ? 0 : pool.get(launches[k].differences)?.[node - tree.levelBegins[level]] ?? 0;
  }
  has(node) { // the selected ray
    const { selection, page } = this;
    const k = this.launchOf(page.tree.level(node));
    if (selection.ray === null || k === undefined || !page.embedded(k)) return false;
    return selection.run.nodesWith(k, selection.ray).some((found) => found.node === node);
  }

  draw() {
    const { page, selection, list } = this;
    const { tree } = page;
    if (this.launches.length === 0 || selection.node === null) {
      this.note.textContent = '';
      list.replaceChildren(element('p', { className: 'quiet', textContent: 'This launch reads no queues.' }));
      return;
    }
    const path = [selection.node];
    while (path[0] > 0) path.unshift(tree.parents[path[0]]);
    const rows = path.slice(0, -1).map((node, depth) => this.row(node, depth));
    const depth = path.length - 1;
    const siblings = depth === 0 ? path : tree.childrenOf(path[depth - 1]);
    for (const node of siblings) {
      rows.push(this.row(node, depth));
      if (node === selection.node) rows.push(...tree.childrenOf(node).map((child) => this.row(child, depth + 1)));
    }
    list.replaceChildren(...rows);
    this.note.textContent = page.runs.b ? 'bars: share of the parent’s queue, A above B' : 'bars: share of the parent’s queue';
  }
  row(node, depth) {
    const { page, selection } = this;
    const { tree } = page;
    const parent = node === 0 ? node : tree.parents[node];
    const bars = Object.values(page.runs).map((run) => {
      const [count, of] = [this.count(node, run), this.count(parent, run)];
      return element('span', { className: `bar ${run.side}`, style: `width: ${of > 0 && count !== null ? Math.min(100, (100 * count) / of) : 0}%` });
    });
    const [a, b] = [this.count(node, page.runs.a), page.runs.b && this.count(node, page.runs.b)];
    const name = tree.isSubtree(node) ? 'subtree' : tree.isLeaf(node) ? `leaf of ${tree.triangles[node]}` : '';
    const differs = this.differs(node);
    return element('div', { className: 'node', role: 'treeitem', 'data-node': String(node), 'aria-level': String(depth + 1),
      'aria-selected': String(node === selection.node), style: `--depth: ${depth}`, title: differs > 0 ? `${differs} entries differ` : '' },
    element('span', { className: `mark${this.has(node) ? ' here' : ''}`, title: this.has(node) ? `ray ${selection.ray} is in this queue` : '' }),
    element('span', { className: 'name number', textContent: String(node) }), element('span', { className: 'kind quiet', textContent: name }),
    element('span', { className: 'bars' }, ...bars),
    element('span', { className: `count number${differs > 0 ? ' fault' : ''}`, textContent: a === null ? '–' : b !== undefined && b !== a ? `${a} / ${b ?? '–'}` : String(a) }));
  }
}

'use strict';
// One selection for all panes: launch, node, ray, pixel, and how they are shown. It lives in the address.

const asWhole = (text) => (/^\d+$/.test(text ?? '') ? Number(text) : null);

// "intersect" of "bounce0/level2/intersect".
const kernelOf = (launch) => launch.name.slice(launch.name.lastIndexOf('/') + 1);

class PageSelection {
  constructor(page, changed) {
    this.page = page;
    this.changed = changed; // draws all panes
    Object.assign(this, { launch: 0, node: null, ray: null, pixel: null, thread: null, side: 'a', float: 'decimal', heat: 'entries' });
    addEventListener('popstate', () => this.read());
    addEventListener('hashchange', () => this.read());
  }

  get at() { return this.page.launches[this.launch]; }
  get run() { return this.page.runs[this.side] ?? this.page.runs.a; }
  get hasQueues() { return isLevelKernel(this.at); }
  get embedded() { return this.page.embedded(this.launch); }
  // The node whose queue this launch reads; null between traversals.
  get shown() { return this.hasQueues && this.node !== null && this.page.tree.level(this.node) === this.at.level ? this.node : null; }

  // `change` has any of the members. The others are made to fit: a launch has its node's level.
  select(change, trail = true) {
    const before = this.address();
    Object.assign(this, change);
    if ('pixel' in change && change.pixel && !('ray' in change)) this.ray = this.page.raysOf(this.at.batch, ...this.pixel)[0] ?? null;
    if ('ray' in change && this.ray !== null) {
      const from = this.page.fromPixel(this.at.batch, this.ray);
      if (from) this.pixel = [from.x, from.y];
    }
    if ('node' in change && this.node !== null && !('launch' in change)) this.followNode();
    else this.followLaunch();
    if (this.told && !this.told.address) this.told.address = this.address();
    if (this.address() !== before) this.write(trail);
    this.changed(this);
  }
  followNode() {
    const level = this.page.tree.level(this.node);
    const found = this.page.traversal(this.launch).find((k) => this.page.launches[k].level === level);
    if (found !== undefined) this.launch = found;
  }
  followLaunch() {
    if (!this.hasQueues || this.shown !== null) return;
    const level = this.at.level;
    const first = this.page.tree.levelBegins[level];
    const where = this.ray === null || !this.embedded ? [] : this.run.nodesWith(this.launch, this.ray);
    if (where.length > 0) { this.node = where[0].node; return; }
    const counts = this.run.counts(this.launch) ?? this.page.runs.a.counts(this.launch);
    let longest = 0;
    counts.forEach((count, i) => { if (count > counts[longest]) longest = i; });
    this.node = first + longest;
  }

  address() {
    return new URLSearchParams(Object.entries(this.words()).filter(([, value]) => value !== undefined)).toString();
  }
  words() {
    return { launch: String(this.at.launch), node: this.node ?? undefined, ray: this.ray ?? undefined, pixel: this.pixel?.join(','),
      side: this.side === 'a' ? undefined : this.side, float: this.float === 'decimal' ? undefined : this.float,
      heat: this.heat === 'entries' ? undefined : this.heat };
  }
  write(trail) { stateToAddress(this.words(), trail); }

  // Reads the address, as far as it names what exists.
  read() {
    const found = stateFromAddress();
    const { page } = this;
    const launch = page.launches.findIndex((l) => l.launch === asWhole(found.launch));
    const node = asWhole(found.node);
    const ray = asWhole(found.ray);
    const [x, y] = (found.pixel ?? '').split(',').map(asWhole);
    const first = found.launch === undefined;
    this.launch = launch >= 0 ? launch : page.first.launch;
    this.node = first ? page.first.node : node !== null && node < page.tree.nodes ? node : null;
    this.ray = first ? page.first.ray : ray !== null && ray < page.rays[this.at.batch] ? ray : null;
    this.pixel = first ? page.first.pixel ?? null : x !== null && y !== null && x < page.width && y < page.height ? [x, y] : null;
    const suspect = first && page.divergences.length > 0; // the fault is in B
    this.side = page.runs.b && (found.side === 'b' || suspect) ? 'b' : 'a';
    this.float = found.float === 'hex' ? 'hex' : 'decimal';
    this.heat = found.heat === 'differences' ? 'differences' : 'entries';
    if (first && this.pixel && this.ray === null) this.ray = page.raysOf(this.at.batch, ...this.pixel)[0] ?? null;
    if (!this.pixel && this.ray !== null) {
      const from = page.fromPixel(this.at.batch, this.ray);
      if (from) this.pixel = [from.x, from.y];
    }
    this.followLaunch();
    this.changed(this);
  }

  step(by) { this.select({ launch: Math.min(this.page.launches.length - 1, Math.max(0, this.launch + by)) }); }
  up() { if (this.node !== null && this.node > 0) this.select({ node: this.page.tree.parents[this.node] }); }
  down() {
    const { tree } = this.page;
    if (this.node === null || tree.isLeaf(this.node)) return;
    const children = tree.childrenOf(this.node);
    const below = this.page.traversal(this.launch).find((k) => this.page.launches[k].level === tree.level(children[0]));
    if (below === undefined) return;
    const gone = this.ray !== null && this.page.embedded(below)
      ? this.run.nodesWith(below, this.ray).find(({ node }) => children.includes(node)) : undefined;
    const counts = this.run.counts(below);
    const length = (child) => counts?.[child - tree.levelBegins[tree.level(child)]] ?? 0;
    this.select({ node: gone?.node ?? children.reduce((most, child) => (length(child) > length(most) ? child : most)) });
  }
  sideways(by) {
    const level = this.page.tree.level(this.node ?? 0);
    const [begin, end] = this.page.tree.levelBegins.slice(level, level + 2);
    if (this.node !== null) this.select({ node: Math.min(end - 1, Math.max(begin, this.node + by)) });
  }
  entry(by) {
    if (this.shown === null || !this.embedded) return;
    const length = this.run.length(this.launch, this.shown);
    if (length === 0) return;
    const here = this.ray === null ? -1 : this.run.nodesWith(this.launch, this.ray).find(({ node }) => node === this.shown)?.position ?? -1;
    this.select({ ray: this.run.ray(this.launch, this.shown, Math.min(length - 1, Math.max(0, here + by))) });
  }

  // Divergences are sorted by launch; n goes on from the selection, and wraps around.
  get divergence() {
    const { told } = this; // the divergence stepped to: another may have the same launch and ray
    if (told !== undefined && told.address === this.address()) return told.index;
    const elsewhere = (node) => node === null || this.page.tree.level(node) !== this.at.level; // in a queue that is written, not read
    return this.page.divergences.findIndex((d) => d.launch === this.launch && (elsewhere(d.node) || d.node === this.node) && (d.ray === null || d.ray === this.ray));
  }
  diverge(by) {
    const all = this.page.divergences;
    if (all.length === 0) return;
    let next = this.divergence;
    if (next >= 0) next = (next + by + all.length) % all.length;
    else if (by > 0) next = Math.max(0, all.findIndex((d) => d.launch > this.launch));
    else next = all.length - 1 - Math.max(0, [...all].reverse().findIndex((d) => d.launch < this.launch));
    this.tell(next);
  }
  tell(index) {
    const { launch, node, ray, side } = this.page.divergences[index];
    this.told = { index };
    this.select({ launch, node: node ?? this.node, ray: ray ?? this.ray, side: side === 'b' ? 'b' : this.side });
  }

  // The next launch that failed, or the next of another kernel: of a thousand divergences most are of one launch. Round at
  // the ends, as n goes; its first divergence is told where it has one.
  nextFailed(by, isWanted) {
    const { page } = this;
    const count = page.launches.length;
    for (let i = 1; i <= count; ++i) {
      const k = (this.launch + by * i + i * count) % count;
      if (!page.failed(k) || !isWanted(k)) continue;
      const index = page.divergences.findIndex((d) => d.launch === k);
      if (index >= 0) this.tell(index); else this.select({ launch: k });
      return;
    }
  }
  divergeLaunch(by) { this.nextFailed(by, (k) => k !== this.launch); }
  divergeStage(by) { this.nextFailed(by, (k) => kernelOf(this.page.launches[k]) !== kernelOf(this.at)); }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.('dialog')) return;
    if (event.key.startsWith('Arrow') && event.target.closest?.('input')) return; // arrows also move in a choice
    const acts = { n: () => this.diverge(1), N: () => this.diverge(-1), l: () => this.divergeLaunch(1), L: () => this.divergeLaunch(-1),
      s: () => this.divergeStage(1), S: () => this.divergeStage(-1), ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1),
      ArrowUp: () => this.up(), ArrowDown: () => this.down(), '[': () => this.sideways(-1), ']': () => this.sideways(1),
      j: () => this.entry(1), k: () => this.entry(-1), b: () => this.page.runs.b && this.select({ side: this.side === 'a' ? 'b' : 'a' }, false),
      x: () => this.select({ float: this.float === 'hex' ? 'decimal' : 'hex' }, false), '?': () => document.getElementById('help').showModal() };
    if (!Object.hasOwn(acts, event.key)) return;
    event.preventDefault();
    acts[event.key]();
  }
}

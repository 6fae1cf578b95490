'use strict';
// The embedded runs: arrays by number, launches, queues, entries. No element of the page is touched here.

// Inflates all at once rather than as a stream, because the data is already here. Every browser's machine is little endian.
async function inflated(base64) {
  const letters = atob(base64);
  const packed = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) packed[i] = letters.charCodeAt(i);
  const stream = new DecompressionStream('deflate');
  const writer = stream.writable.getWriter();
  // A broken stream is reported by the reader below; these two would report it again.
  writer.write(packed).catch(() => {});
  writer.close().catch(() => {});
  const reader = stream.readable.getReader();
  const chunks = [];
  for (let next = await reader.read(); !next.done; next = await reader.read()) chunks.push(next.value);
  const bytes = new Uint8Array(chunks.reduce((all, chunk) => all + chunk.length, 0));
  let at = 0;
  for (const chunk of chunks) { bytes.set(chunk, at); at += chunk.length; }
  return bytes.buffer;
}

class Pool {
  static async open({ arrays, blobs }) {
    const pool = new Pool();
    const buffers = await Promise.all(blobs.map(inflated));
    const types = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array };
    pool.arrays = arrays.map(([blob, type, begin, count]) => new types[type](buffers[blob], begin, count));
    return pool;
  }
  get(number) { return number === undefined ? null : this.arrays[number]; }
  bits(number) { // of floats
    const floats = this.get(number);
    return floats && new Uint32Array(floats.buffer, floats.byteOffset, floats.length);
  }
}

const sumBefore = (counts) => {
  const begins = new Uint32Array(counts.length + 1);
  for (let i = 0; i < counts.length; ++i) begins[i + 1] = begins[i] + counts[i];
  return begins;
};

class Tree {
  constructor(data, scene, pool) {
    this.levelBegins = data.level_begins;
    this.parents = pool.get(data.parents);
    this.triangles = pool.get(data.triangles);
    this.boxes = pool.get(data.boxes);
    this.corners = scene && pool.get(scene.corners);
    this.firstTriangle = scene && pool.get(scene.first);
    this.nodes = this.parents.length;
    this.levels = this.levelBegins.length - 1;
    this.firstChild = new Uint32Array(this.nodes); // breadth-first: a node's children are neighbours
    this.children = new Uint8Array(this.nodes);
    for (let node = this.nodes - 1; node > 0; --node) {
      this.firstChild[this.parents[node]] = node;
      ++this.children[this.parents[node]];
    }
  }
  isSubtree(node) { return this.children[node] > 0 && node >= this.levelBegins[this.levels - 1]; }
  isLeaf(node) { return this.triangles[node] > 0 || this.isSubtree(node); } // it pushes no rays on
  level(node) { return this.levelBegins.findIndex((_, l) => node < this.levelBegins[l + 1]); }
  below(node) { return Array.from({ length: this.children[node] }, (_, i) => this.firstChild[node] + i); }
  childrenOf(node) { return this.isSubtree(node) ? [] : this.below(node); }
  box(node) { return this.boxes.subarray(6 * node, 6 * node + 6); }
  under(node, most) { // leaves below a node, or itself
    const leaves = [];
    for (const open = [node]; open.length > 0 && leaves.length < most;) {
      const next = open.pop();
      if (this.triangles[next] > 0) leaves.push(next);
      else open.push(...this.below(next).reverse());
    }
    return leaves;
  }
}

const isLevelKernel = (launch) => launch.kind === 'intersect_root' || launch.kind === 'intersect';

// One of the two runs. Launches are numbers in the page's list, which is A's.
class Run {
  constructor(page, side) {
    this.page = page;
    this.side = side;
    this.indices = new Map();
  }
  arrays(k) {
    const launch = this.page.launches[k];
    if (this.side === 'a') return launch.arrays;
    return launch.verdict === 'missing' ? undefined : launch.arrays_b ?? launch.arrays;
  }
  get(k, name) { return this.page.pool.get(this.arrays(k)?.[name]); }
  counts(k) { // always there: the launch's queue lengths, by node of the level
    const launch = this.page.launches[k];
    return this.page.pool.get(this.side === 'b' ? launch.counts_b : launch.counts);
  }
  // Where each node's entries begin, each entry's outcome, and where a child's entries begin.
  index(k) {
    if (!this.indices.has(k)) this.indices.set(k, this.arrays(k)?.queue === undefined ? null : this.makeIndex(k));
    return this.indices.get(k);
  }
  makeIndex(k) {
    const { tree } = this.page;
    const queue = this.get(k, 'queue');
    const begins = sumBefore(this.get(k, 'lengths'));
    const did = this.get(k, 'did');
    const met = new Uint32Array(queue.length + 1);
    const closest = new Int32Array(queue.length).fill(-1);
    const gathered = new Int32Array(queue.length).fill(-1);
    const first = tree.levelBegins[this.page.launches[k].level];
    let closestSeen = 0;
    let gatheredSeen = 0;
    for (let node = 0; node + 1 < begins.length; ++node) {
      const leaf = tree.isLeaf(first + node);
      for (let e = begins[node]; e < begins[node + 1]; ++e) {
        met[e + 1] = met[e] + (leaf ? 0 : did[e]);
        if (!leaf || did[e] === 0) continue;
        closest[e] = closestSeen++;
        if (leafOutcomes[did[e]] === 'buffered' || leafOutcomes[did[e]] === 'other') gathered[e] = gatheredSeen++;
      }
    }
    return { first, queue, begins, did, met, closest, gathered, hits: sumBefore(this.get(k, 'hits')),
      childBegins: this.arrays(k).child_counts === undefined ? null : sumBefore(this.get(k, 'child_counts')),
      childQueue: this.get(k, 'child_queue') };
  }
  length(k, node) {
    const index = this.index(k);
    return index ? index.begins[node - index.first + 1] - index.begins[node - index.first] : 0;
  }
  ray(k, node, position) {
    const index = this.index(k);
    return index.queue[index.begins[node - index.first] + position];
  }
  record(k, ray) { // origin, t_min, direction, t_max; null if the id is no ray's
    const rays = this.get(k, 'rays');
    return rays && 8 * ray + 8 <= rays.length ? rays.subarray(8 * ray, 8 * ray + 8) : null;
  }
  minimum(k, ray) {
    const minimum = this.get(k, 'minimum');
    return minimum && ray < minimum.length ? minimum[ray] : null;
  }
  place(k, node, position) {
    const threads = this.page.launches[k].threads;
    const places = this.get(k, 'places'); // of a queue of pairs: where each entry of a node stands in it
    if (places) {
      const at = places[this.index(k).begins[node - this.index(k).first] + position];
      return { block: Math.floor(at / threads), thread: at % threads };
    }
    return { block: this.get(k, 'block_offsets')[node - this.index(k).first] + Math.floor(position / threads), thread: position % threads };
  }
  // The place of a ray in the queue that the launch has written for a child.
  below(k, child, ray) {
    const { childBegins, childQueue, first } = this.index(k);
    if (!childBegins) return { position: null, times: 0 };
    const level = this.page.tree.level(first);
    const at = child - this.page.tree.levelBegins[level + 1];
    let position = null;
    let times = 0;
    for (let e = childBegins[at]; e < childBegins[at + 1]; ++e) {
      if (childQueue[e] !== ray) continue;
      if (times++ === 0) position = e - childBegins[at];
    }
    return { position, times };
  }
  nodesWith(k, ray) {
    const index = this.index(k);
    const found = [];
    if (!index) return found;
    for (let node = 0; node + 1 < index.begins.length; ++node) {
      for (let e = index.begins[node]; e < index.begins[node + 1]; ++e) {
        if (index.queue[e] === ray) found.push({ node: index.first + node, position: e - index.begins[node] });
      }
    }
    return found;
  }
}

async function openPage(data) {
  const page = { ...data, pool: await Pool.open(data.pool) };
  page.checksums = data.pool.arrays.map((array) => array[4]);
  page.tree = new Tree(data.tree, data.scene_triangles, page.pool);
  page.runs = { a: new Run(page, 'a') };
  if (data.b) page.runs.b = new Run(page, 'b');
  page.provenance = data.from.map((from) => from && { pixel: page.pool.get(from.pixel), sample: page.pool.get(from.sample) });
  page.width = data.parameters.image_width;
  page.height = data.parameters.image_height;
  page.embedded = (k) => page.launches[k].arrays !== undefined;
  page.failed = (k) => page.launches[k].differs === true || page.launches[k].verdict === 'missing'
    || page.launches[k].invariants.a.length > 0 || page.launches[k].invariants.b.length > 0;
  page.traversal = (k) => {
    const { batch, bounce, light } = page.launches[k];
    return page.launches.flatMap((l, i) => (isLevelKernel(l) && l.batch === batch && l.bounce === bounce && l.light === light ? [i] : []));
  };
  page.fromPixel = (batch, ray) => {
    const from = page.provenance[batch];
    if (!from || ray === null || ray >= from.pixel.length) return null;
    return { x: from.pixel[ray] % page.width, y: Math.floor(from.pixel[ray] / page.width), sample: from.sample[ray] };
  };
  page.raysOf = (batch, x, y) => {
    const rays = [];
    page.provenance[batch]?.pixel.forEach((pixel, ray) => { if (pixel === y * page.width + x) rays.push(ray); });
    return rays;
  };
  // The model's pairs of a node; null if all entries are the same.
  page.pairs = (k, node) => {
    const { pairs } = page.launches[k];
    if (!pairs) return null;
    const nodes = page.pool.get(pairs.node);
    const at = nodes.indexOf(node);
    if (at < 0) return null;
    const [begin, end] = sumBefore(page.pool.get(pairs.pairs)).slice(at, at + 2);
    const [a, b, change, what] = ['a', 'b', 'change', 'what'].map((name) => page.pool.get(pairs[name]).subarray(begin, end));
    return Array.from(a, (_, i) => ({ a: a[i] - 1, b: b[i] - 1, change: changes[change[i]], what: what[i] }));
  };
  return page;
}

const outcomes = ['missed', 'culled', 'pushed', 'lost', 'extra', 'tested'];
const leafOutcomes = ['no hit', 'beyond', 'buffered', 'passed', 'lost', 'other'];
const changes = ['same', 'moved', 'changed', 'missing', 'extra'];

// A float32 as C prints it with %a: exact to the bit.
function hexFloat(value) {
  if (!Number.isFinite(value)) return String(value).replace('Infinity', '∞');
  words.setFloat32(0, value);
  const bits = words.getUint32(0);
  const sign = bits >>> 31 ? '-' : '';
  let exponent = (bits >>> 23) & 0xff;
  let mantissa = bits & 0x7fffff;
  if (exponent === 0 && mantissa === 0) return `${sign}0x0p+0`;
  if (exponent === 0) {
    exponent = 1;
    while (!(mantissa & 0x800000)) { mantissa <<= 1; --exponent; }
    mantissa &= 0x7fffff;
  }
  const digits = (mantissa << 1).toString(16).padStart(6, '0').replace(/0+$/, '');
  const power = exponent - 127;
  return `${sign}0x1${digits ? `.${digits}` : ''}p${power < 0 ? '-' : '+'}${Math.abs(power)}`;
}

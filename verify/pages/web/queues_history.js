'use strict';
// A ray's history, assembled from the arrays: the document that `scotty queues --ray R --json` prints.

const word = (value) => (value === null || value === undefined ? null : Number.isFinite(value) ? value : String(value));
const rayDocument = (r) => (r ? { origin: [word(r[0]), word(r[1]), word(r[2])], direction: [word(r[4]), word(r[5]), word(r[6])],
  t_min: word(r[3]), t_max: word(r[7]) } : null);
const some = (id) => (id === 0xffffffff ? null : id);

class RayHistory {
  constructor(page, side, batch, ray) {
    Object.assign(this, { page, run: page.runs[side], side, batch, ray });
    this.absent = []; // launches that are not embedded
    const from = page.fromPixel(batch, ray);
    this.document = { batch, ray, pixel: from ? [from.x, from.y] : null, sample: from ? from.sample : null,
      minimum_is_later: page.parameters.early_out === 'immediate', bounces: [], radiance: null, pixel_value: null };
    page.launches.forEach((launch, k) => {
      if (launch.batch !== batch || launch.verdict === 'missing' && side === 'b') return;
      if (!page.embedded(k)) { this.absent.push(k); return; }
      this.add(launch, k);
    });
  }

  emptyTraversal(name) {
    return { name, ray: null, gaps: [], visits: [], stray: [], merge_launch: null, merged: null, winner_node: null };
  }
  bounce(launch) {
    const { bounces } = this.document;
    for (let b = bounces.length; b <= (launch.bounce ?? 0); ++b) {
      bounces.push({ bounce: b, traversal: this.emptyTraversal(`bounce${b}`), lights: [], flags: null, next: null, throughput: null, radiance: null });
    }
    return bounces[launch.bounce ?? 0];
  }
  light(launch) {
    const bounce = this.bounce(launch);
    for (let l = bounce.lights.length; l <= launch.light; ++l) {
      bounce.lights.push({ light: l, shadow_ray: null, potential: null, traversal: this.emptyTraversal(`bounce${bounce.bounce}/light${l}`), radiance: null });
    }
    return bounce.lights[launch.light];
  }
  traversal(launch) { return launch.light === null ? this.bounce(launch).traversal : this.light(launch).traversal; }

  rayIn(k, name) {
    const rays = this.run.get(k, name);
    return rays && 8 * this.ray + 8 <= rays.length ? rayDocument(rays.subarray(8 * this.ray, 8 * this.ray + 8)) : null;
  }
  vector(k, name, at = this.ray) {
    const vectors = this.run.get(k, name);
    return vectors && 3 * at + 3 <= vectors.length ? [...vectors.subarray(3 * at, 3 * at + 3)].map(word) : null;
  }

  add(launch, k) {
    if (isLevelKernel(launch)) {
      const traversal = this.traversal(launch);
      traversal.ray = this.rayIn(k, 'rays');
      traversal.gaps = (this.side === 'b' ? launch.gaps_b : launch.gaps) ?? traversal.gaps;
      for (const { node, position } of this.run.nodesWith(k, this.ray)) traversal.visits.push(visitDocument(this.run, k, node, position));
    } else if (launch.kind === 'merge_intersections') this.addMerge(launch, k);
    else if (launch.kind === 'direct_light_rays') {
      Object.assign(this.light(launch), { shadow_ray: this.rayIn(k, 'shadow_rays'), potential: this.vector(k, 'potential') });
    } else if (launch.kind === 'resolve_light') this.light(launch).radiance = this.vector(k, 'radiance');
    else if (launch.kind === 'scene_rays') {
      Object.assign(this.bounce(launch), { flags: this.run.get(k, 'flags')?.[this.ray] ?? null, next: this.rayIn(k, 'rays'),
        throughput: this.vector(k, 'throughput'), radiance: this.vector(k, 'radiance') });
    } else if (launch.kind === 'reconstruct_image') this.addImage(k);
  }
  addMerge(launch, k) {
    const traversal = this.traversal(launch);
    const merged = this.run.get(k, 'merged');
    traversal.merge_launch = launch.launch;
    traversal.ray ??= this.rayIn(k, 'rays');
    if (merged && 4 * this.ray + 4 <= merged.length) {
      const [t, , u, v] = merged.subarray(4 * this.ray, 4 * this.ray + 4);
      traversal.merged = { t: word(t), primitive: some(this.page.pool.bits(this.run.arrays(k).merged)[4 * this.ray + 1]), u: word(u), v: word(v) };
    }
    const winner = this.run.get(k, 'winner_node')?.[this.ray] ?? 0;
    traversal.winner_node = winner === 0 ? null : winner - 1;
    traversal.stray = (this.run.arrays(k).stray ?? []).filter(([ray]) => ray === this.ray)
      .map(([, slot, t, primitive, won]) => ({ slot, t: word(t), primitive: some(primitive), won }));
  }
  addImage(k) {
    this.document.radiance = this.vector(k, 'radiance');
    const image = this.page.pool.get(this.page.images?.[this.side]);
    if (!image || !this.document.pixel) return;
    const at = 3 * (this.document.pixel[1] * this.page.width + this.document.pixel[0]);
    this.document.pixel_value = [...image.subarray(at, at + 3)].map(word);
  }
}

// What the ray in that entry did, as the model has found.
function visitDocument(run, k, node, position) {
  const launch = run.page.launches[k];
  const { tree } = run.page;
  const index = run.index(k);
  const entry = index.begins[node - index.first] + position;
  const ray = index.queue[entry];
  const number = run.side === 'b' ? launch.launch_b ?? launch.launch : launch.launch;
  const visit = { launch: number, stage: launch.name, level: launch.level, node, position, ...run.place(k, node, position), minimum: word(run.minimum(k, ray)) };
  if (tree.isSubtree(node)) visit.subtree = true;
  if (tree.isLeaf(node)) visit.leaf = leafDocument(run, k, index, entry);
  else visit.children = childDocuments(run, k, index, entry, node, ray);
  return visit;
}

function childDocuments(run, k, index, entry, node, ray) {
  const children = run.page.tree.childrenOf(node).map((child) => ({ node: child, outcome: 'missed', entry: null, position: null, times: 0 }));
  const met = run.get(k, 'met');
  const distance = run.get(k, 'met_entry');
  for (let i = index.met[entry]; i < index.met[entry + 1]; ++i) {
    const child = children[met[i] % 16];
    child.outcome = outcomes[met[i] >> 4];
    child.entry = Number.isNaN(distance[i]) ? null : word(distance[i]);
    if (!['culled', 'lost', 'tested'].includes(child.outcome)) Object.assign(child, run.below(k, child.node, ray));
  }
  return children;
}

function leafDocument(run, k, index, entry) {
  const at = index.closest[entry];
  const primitive = at < 0 ? null : some(run.get(k, 'closest_primitive')[at]);
  const leaf = { outcome: leafOutcomes[index.did[entry]], closest: primitive === null ? null : { t: word(run.get(k, 'closest_t')[at]), primitive }, hits: [] };
  const gathered = index.gathered[entry];
  if (gathered < 0) return leaf;
  for (let i = index.hits[gathered]; i < index.hits[gathered + 1]; ++i) {
    const slot = run.get(k, 'hit_slot')[i];
    leaf.hits.push({ slot: slot >> 1, t: word(run.get(k, 'hit_t')[i]), primitive: some(run.get(k, 'hit_primitive')[i]), won: (slot & 1) === 1 });
  }
  return leaf;
}

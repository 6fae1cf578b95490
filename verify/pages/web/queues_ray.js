'use strict';
// A ray's history as text: traversal by traversal, visit by visit, for both runs if there are two.

class RayPane {
  constructor(at, page, selection) {
    Object.assign(this, { box: at.ray, note: at['ray-note'], page, selection, open: new Set() });
    this.box.addEventListener('click', (event) => {
      const target = event.target.closest('[data-launch]');
      if (!target) return;
      const launch = page.launches.findIndex((l) => l.launch === Number(target.dataset.launch));
      selection.select({ launch, ...(target.dataset.node ? { node: Number(target.dataset.node) } : {}) });
    });
  }
  float(value) {
    if (value === null) return '–';
    const number = Number(value);
    return this.selection.float === 'hex' ? hexFloat(number) : short(number);
  }
  vector(v) { return v ? `(${v.map((c) => this.float(c)).join(', ')})` : '–'; }

  draw() {
    const { page, selection } = this;
    if (selection.ray === null) {
      this.note.textContent = '';
      this.box.replaceChildren(element('p', { className: 'quiet', textContent: 'Choose an entry of the queue, or a pixel.' }));
      return;
    }
    const key = `${selection.at.batch} ${selection.ray}`;
    if (key !== this.key) {
      this.key = key;
      this.histories = Object.fromEntries(Object.keys(page.runs).map((side) => [side, new RayHistory(page, side, selection.at.batch, selection.ray)]));
    }
    const { document: a, absent } = this.histories.a;
    const b = this.histories.b?.document ?? null;
    this.note.textContent = `${selection.ray}${page.batches > 1 ? ` of batch ${a.batch}` : ''}${a.pixel ? `, pixel ${a.pixel.join(', ')}${a.sample > 0 ? ` sample ${a.sample}` : ''}` : ''}`;
    const parts = [this.siblings(a)];
    a.bounces.forEach((bounce, i) => parts.push(...this.bounce(bounce, b?.bounces[i] ?? null)));
    if (a.radiance) parts.push(this.line('radiance of the path', a.radiance, b?.radiance));
    if (a.pixel_value) parts.push(this.line('the pixel', a.pixel_value, b?.pixel_value));
    if (absent.length > 0) {
      parts.push(element('p', { className: 'quiet', textContent: `${absent.length} launches of its way are not embedded. All of it:` }),
        command(`${page.command} --ray ${selection.ray}${page.batches > 1 ? ` --batch ${a.batch}` : ''}`, 'show the whole history'));
    }
    this.box.replaceChildren(...parts.filter(Boolean));
  }
  siblings(a) {
    if (!a.pixel) return null;
    const rays = this.page.raysOf(a.batch, ...a.pixel);
    if (rays.length < 2) return null;
    const buttons = rays.map((ray, i) => {
      const button = element('button', { type: 'button', textContent: String(i), title: `ray ${ray}`, 'aria-pressed': String(ray === this.selection.ray) });
      button.addEventListener('click', () => this.selection.select({ ray }));
      return button;
    });
    return element('p', { className: 'samples quiet' }, 'samples of the pixel ', ...buttons);
  }
  line(what, a, b) {
    const differs = b !== undefined && b !== null && String(a) !== String(b);
    const line = element('p', { className: 'outcome' }, element('span', { className: 'quiet', textContent: `${what} ` }), element('span', { className: 'number', textContent: this.vector(a) }));
    if (differs) line.append(element('span', { className: 'number fault', textContent: ` B ${this.vector(b)}` }));
    return line;
  }

  bounce(a, b) {
    const parts = [this.traversal(a.traversal, b?.traversal ?? null)];
    a.lights.forEach((light, i) => {
      if (light.shadow_ray && Number(light.shadow_ray.t_max) < Number(light.shadow_ray.t_min)) return; // no light was asked for
      parts.push(this.traversal(light.traversal, b?.lights[i]?.traversal ?? null, light));
    });
    return parts;
  }
  // A dead ray that went nowhere has no history.
  happened(t) { return t.ray === null || Number(t.ray.t_max) >= Number(t.ray.t_min) || t.visits.length > 1 || t.stray.length > 0; }

  traversal(a, b, light = null) {
    if (!this.happened(a) && !(b && this.happened(b))) return null;
    const here = a.visits.some((visit) => visit.launch === this.selection.at.launch) || a.merge_launch === this.selection.at.launch;
    const [inA, inB] = [this.outcome(a, light), b && this.outcome(b, light)];
    const differs = b !== null && inA !== inB ? `; B: ${inB}` : b !== null && this.steps(a) !== this.steps(b) ? '; B: the same, another way' : '';
    const summary = element('summary', {}, element('b', { textContent: a.name.replace('bounce', 'bounce ').replace('/light', ', light ') }),
      element('span', { className: 'quiet', textContent: inA }), element('span', { className: 'fault', textContent: differs }));
    const details = element('details', { open: here || this.open.has(a.name) }, summary);
    details.addEventListener('toggle', () => { if (details.open) this.open.add(a.name); else this.open.delete(a.name); });
    if (a.ray) {
      details.append(element('p', { className: 'outcome number quiet', textContent:
        `from ${this.vector(a.ray.origin)} to ${this.vector(a.ray.direction)}, t ${this.float(a.ray.t_min)} … ${this.float(a.ray.t_max)}` }));
    }
    for (const gap of a.gaps) details.append(element('p', { className: 'quiet', textContent: `not captured: ${gap}` }));
    for (const [x, y] of this.paired(a, b)) details.append(this.visit(x, y, b !== null));
    for (const hit of a.stray) details.append(element('p', { className: 'fault', textContent: `buffered primitive ${hit.primitive} in slot ${hit.slot}, from no leaf that the ray was in` }));
    return details;
  }
  outcome(t, light) {
    if (!t.merged) return 'not merged';
    const hit = t.merged.primitive !== null;
    if (light) return hit ? `hidden by primitive ${t.merged.primitive}` : 'free';
    return hit ? `hits primitive ${t.merged.primitive} at ${this.float(t.merged.t)}` : 'hits nothing';
  }
  steps(t) { return t.visits.map((visit) => visit.node + this.did(visit)).join(); }
  did(visit) {
    if (visit.leaf) return visit.leaf.outcome + visit.leaf.hits.map((hit) => `${hit.primitive} ${hit.won}`).sort().join();
    return visit.children.map((child) => child.outcome + child.times).join();
  }
  // Pairs the n-th visit of a node with the n-th in B, in order of nodes.
  paired(a, b) {
    if (!b) return a.visits.map((visit) => [visit, null]);
    const left = [...b.visits];
    const pairs = a.visits.map((visit) => {
      const at = left.findIndex((other) => other.node === visit.node);
      return [visit, at < 0 ? null : left.splice(at, 1)[0]];
    });
    return [...pairs, ...left.map((visit) => [null, visit])].sort(([x, y], [u, v]) => (x ?? y).node - (u ?? v).node);
  }

  visit(a, b, two) {
    const shown = a ?? b;
    const here = shown.launch === this.selection.at.launch && shown.node === this.selection.shown;
    const place = element('button', { type: 'button', className: 'place', 'data-launch': String(shown.launch), 'data-node': String(shown.node) },
      element('span', { className: 'quiet', textContent: `level ${shown.level} ` }), element('span', { className: 'number', textContent: `node ${shown.node}` }));
    const row = element('div', { className: `visit${here ? ' here' : ''}` }, place,
      element('span', { className: 'quiet small', textContent: `entry ${shown.position}, block ${shown.block} thread ${shown.thread}${shown.minimum === null ? '' : `, minimum ${this.float(shown.minimum)}`}` }));
    if (two && (a === null || b === null)) {
      row.append(element('span', { className: 'fault', textContent: a === null ? 'only in B' : 'not in B' }));
    }
    row.append(this.deeds(shown));
    if (a && b && this.did(a) !== this.did(b)) row.append(element('div', { className: 'deeds' }, element('span', { className: 'fault', textContent: 'B:' }), ...this.deeds(b).childNodes));
    return row;
  }
  deeds(visit) {
    const line = element('div', { className: 'deeds' });
    if (visit.leaf) { line.append(...this.leaf(visit)); return line; }
    const missed = visit.children.filter((child) => child.outcome === 'missed').length;
    for (const child of visit.children.filter((c) => c.outcome !== 'missed')) {
      const bad = child.outcome === 'lost' || child.outcome === 'extra';
      const why = [child.entry === null ? 'it misses the box' : `enters at ${this.float(child.entry)}`];
      if (child.outcome === 'culled') why.push(`beyond ${this.float(visit.minimum)}`);
      if (child.position !== null) why.push(`entry ${child.position} there`);
      if (child.times > 1) why.push(`${child.times} times in its queue`);
      if (child.outcome === 'lost') why.push('not in its queue');
      line.append(element('span', { className: `deed ${child.outcome}`, title: why.join(', ') },
        element('span', { className: bad ? 'fault' : 'quiet', textContent: `${child.outcome} ` }), element('span', { className: 'number', textContent: String(child.node) }),
        element('span', { className: 'quiet', textContent: child.outcome === 'pushed' ? '' : ` ${why.join(', ')}` })));
    }
    if (missed > 0) line.append(element('span', { className: 'quiet deed', textContent: missed === visit.children.length ? 'misses all children' : `misses ${missed}` }));
    return line;
  }
  leaf({ leaf, minimum }) {
    const closest = leaf.closest ? `primitive ${leaf.closest.primitive} at ${this.float(leaf.closest.t)}` : '';
    const say = (text, fault = false) => element('span', { className: fault ? 'deed fault' : 'deed quiet', textContent: text });
    const hits = leaf.hits.map((hit) => say(`buffered primitive ${hit.primitive} at ${this.float(hit.t)}, slot ${hit.slot}${hit.won ? ': won' : ''}`));
    switch (leaf.outcome) {
      case 'no hit': return [say('no triangle is hit')];
      case 'beyond': return [say(`${closest}, beyond the minimum ${this.float(minimum)}`)];
      case 'passed': return [say(`${closest}, but there was a nearer one`)];
      case 'lost': return [say(`${closest}, but it is not in the ray’s buffer`, true)];
      case 'other': return [...hits, say(closest ? `its closest is ${closest}` : 'no triangle is hit', true)];
      default: return hits;
    }
  }
}

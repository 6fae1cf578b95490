'use strict';
// The launch's invariants, the bar that shows the selection, and the start of the page.

class ChecksPane {
  constructor(at, page, selection) {
    Object.assign(this, { box: at.checks, note: at['checks-note'], page, selection });
    this.box.addEventListener('click', (event) => {
      const target = event.target.closest('[data-ray], [data-node]');
      const asked = (name) => (target?.dataset[name] === undefined ? undefined : Number(target.dataset[name]));
      if (target) selection.select({ ...(asked('node') === undefined ? {} : { node: asked('node') }), ...(asked('ray') === undefined ? {} : { ray: asked('ray') }) });
    });
  }
  draw() {
    const { page, selection } = this;
    const { names, ...said } = selection.at.invariants;
    const sides = page.runs.b ? ['a', 'b'] : ['a'];
    const asked = sides.filter((side) => page[side].checked);
    this.note.textContent = `of ${selection.at.name}`;
    if (asked.length === 0) {
      this.box.replaceChildren(element('p', { className: 'quiet', textContent: 'Not checked: only a part of the run was captured, and a launch is held to what came before it.' }));
      return;
    }
    const all = [...new Set([...names, ...asked.flatMap((side) => said[side].map((f) => f.name))])];
    const cell = (side, name) => {
      if (!page[side].checked) return element('td', { className: 'quiet', textContent: 'not checked' });
      const failed = said[side].filter((f) => f.name === name).length;
      return element('td', { className: failed > 0 ? 'fault' : 'quiet', textContent: failed > 0 ? `fails${failed > 1 ? ` ${failed}${said[side].length >= 100 ? '+' : ''} times` : ''}` : 'holds' });
    };
    const table = element('table', { className: 'invariants' },
      ...(sides.length > 1 ? [element('thead', {}, element('tr', {}, element('th', { scope: 'col' }), ...sides.map((side) => element('th', { scope: 'col', textContent: side.toUpperCase() }))))] : []),
      element('tbody', {}, ...all.map((name) => element('tr', {}, element('th', { scope: 'row', textContent: name }), ...sides.map((side) => cell(side, name))))));
    const list = asked.flatMap((side) => said[side].slice(0, 12).map((failure) => this.failure(failure, sides.length > 1 ? `${side.toUpperCase()}: ` : '')));
    const more = asked.reduce((n, side) => n + Math.max(0, said[side].length - 12), 0);
    if (more > 0) list.push(element('p', { className: 'quiet', textContent: `and ${more} more` }));
    this.box.replaceChildren(table, ...list);
  }
  failure(failure, side) {
    const place = [['node', failure.node], ['block', failure.block], ['ray', failure.ray]].filter(([, n]) => n !== null).map(([what, n]) => `${what} ${n}`).join(', ');
    const row = element('div', { className: 'failure' }, element('span', { className: 'fault', textContent: `${side}${failure.name}` }));
    if (place) {
      const button = element('button', { type: 'button', className: 'place', textContent: place });
      for (const name of ['node', 'ray']) if (failure[name] !== null) button.dataset[name] = String(failure[name]);
      row.append(button);
    }
    row.append(element('p', { textContent: failure.text }));
    return row;
  }
}

class Bar {
  constructor(at, page, selection) {
    Object.assign(this, { at, page, selection });
    at.next.addEventListener('click', () => selection.diverge(1));
    at.previous.addEventListener('click', () => selection.diverge(-1));
    for (const [id, by] of [['next', 1], ['previous', -1]]) {
      at[`${id}-launch`].addEventListener('click', () => selection.divergeLaunch(by));
      at[`${id}-stage`].addEventListener('click', () => selection.divergeStage(by));
    }
    at['help-button'].addEventListener('click', () => at.help.showModal());
    this.head();
  }
  head() {
    const { at, page } = this;
    const failed = page.launches.filter((_, k) => page.failed(k)).length;
    at.scene.textContent = page.scene;
    const first = page.divergences[0];
    at.lead.className = first ? 'fault' : '';
    const what = page.runs.b ? 'differ or break an invariant' : 'break an invariant';
    at.lead.textContent = first ? `${failed} of ${page.launches.length} launches ${what}; the first is launch ${page.launches[first.launch].launch}, ${page.launches[first.launch].name}.`
      : page.runs.b ? `All ${page.launches.length} launches are equal.` : page.a.checked ? `All ${page.launches.length} launches keep the invariants.` : `${page.launches.length} launches.`;
    const p = page.parameters;
    const run = ({ path, backend }) => `${path} (${backend})`;
    at.about.textContent = `${page.runs.b ? `A is ${run(page.a)}, B is ${run(page.b)}` : run(page.a)}. ${p.image_width} x ${p.image_height} pixels, ${p.spp} sample${p.spp === 1 ? '' : 's'}, `
      + `${p.width} children a node, ${p.rays_per_block} rays per block, early-out ${p.early_out}, hits ${p.hit_mode}. ${page.tree.nodes} nodes in ${page.tree.levels} levels.`
      + (page.only_in_b > 0 ? ` ${page.only_in_b} launches are in B only.` : '');
  }
  draw() {
    const { at, page, selection } = this;
    const item = (what, value) => element('span', {}, element('span', { className: 'quiet', textContent: `${what} ` }), element('span', { className: 'number', textContent: String(value) }));
    at.where.replaceChildren(...[item('launch', selection.at.launch), element('span', { className: 'name number', textContent: selection.at.name }),
      selection.shown !== null && item('node', selection.shown), selection.ray !== null && item('ray', selection.ray),
      selection.pixel && item('pixel', selection.pixel.join(', '))].filter(Boolean));
    const here = selection.divergence;
    at.next.disabled = at.previous.disabled = page.divergences.length === 0;
    const failed = page.launches.flatMap((launch, k) => (page.failed(k) && k !== selection.launch ? [launch] : []));
    at['next-launch'].disabled = at['previous-launch'].disabled = failed.length === 0;
    at['next-stage'].disabled = at['previous-stage'].disabled = failed.every((launch) => kernelOf(launch) === kernelOf(selection.at));
    const told = page.divergences[here];
    at.said.hidden = !told;
    if (told) {
      const side = told.side === 'diff' ? '' : page.runs.b ? ` in ${told.side.toUpperCase()}` : '';
      at.said.replaceChildren(element('p', {}, element('span', { className: 'quiet', textContent: `${here + 1} of ${page.divergences.length + page.more_divergences}  ` }),
        element('b', { className: 'fault', textContent: `${told.what}${side}: ` }), told.text),
      ...(selection.at.replay ? [command(selection.at.replay, 'run this launch again')] : []));
    }
    at.unembedded.hidden = selection.embedded;
    if (!selection.embedded) {
      const number = page.launches.filter((l) => l.arrays !== undefined).length;
      at.unembedded.replaceChildren(element('p', { className: 'quiet', textContent: `This launch is not embedded: ${number} of ${page.launches.length} launches are, and the counts of all. A page around this one:` }),
        command(`${page.command} --launch ${selection.at.launch} --html queues.html`, 'embed this launch'));
    }
  }
}

async function start() {
  const at = Object.fromEntries([...document.querySelectorAll('[id]')].map((e) => [e.id, e]));
  const page = await openPage(JSON.parse(at['queues-data'].textContent));
  let panes = [];
  const selection = new PageSelection(page, () => {
    selection.pixelRays = new Set(selection.pixel ? page.raysOf(selection.at.batch, ...selection.pixel) : []);
    for (const pane of panes) pane.draw();
  });
  panes = [Bar, Timeline, Heat, TreePane, QueuePane, BlockPane, SpacePane, ImagePane, RayPane, ChecksPane].map((Pane) => new Pane(at, page, selection));
  const redraw = () => { for (const pane of panes) pane.draw(); };
  document.addEventListener('keydown', (event) => selection.key(event));
  addEventListener('resize', redraw);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  selection.read();
  return { page, selection, panes };
}
const started = start();

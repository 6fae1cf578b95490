'use strict';
// The page's test of itself: it drives the page by keys, pointer and clicks, and compares the result with the raw arrays and
// with histories from the model (element "told", which a test puts in).

const shownText = (id) => document.getElementById(id).textContent;
const inkBytes = (context, x, y) => { const s = devicePixelRatio || 1; return [...context.getImageData(Math.round(x * s), Math.round(y * s), 1, 1).data].slice(0, 3).join(); };
const bytesText = (css) => { const c = element('canvas', { width: 1, height: 1 }).getContext('2d'); c.fillStyle = css; c.fillRect(0, 0, 1, 1); return [...c.getImageData(0, 0, 1, 1).data].slice(0, 3).join(); };

function clickAt(canvas, x, y, type = 'click') {
  const box = canvas.getBoundingClientRect();
  canvas.dispatchEvent(new PointerEvent(type, { bubbles: true, clientX: box.left + x, clientY: box.top + y, pointerId: 1 }));
}

// The path at which two documents part.
function firstDifference(a, b, path = '') {
  if (a === null || b === null || typeof a !== 'object' || typeof b !== 'object') return Object.is(a, b) ? null : `${path}: ${a}, ${b}`;
  for (const key of new Set([...Object.keys(a), ...Object.keys(b)])) {
    if (!(key in a) || !(key in b)) return `${path}.${key} is on one side only`;
    const found = firstDifference(a[key], b[key], `${path}.${key}`);
    if (found) return found;
  }
  return null;
}

function testArrays(test, { page }) {
  page.pool.arrays.forEach((array, number) => {
    const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
    let sum = 0;
    for (const byte of bytes) sum = (sum + byte) >>> 0;
    if (sum !== page.checksums[number]) test.equal(`checksum of array ${number}`, sum, page.checksums[number]);
  });
  test.equal('arrays are there', page.pool.arrays.length > 0, true);
}

function testHistories(test, { page }) {
  const told = JSON.parse(document.getElementById('told')?.textContent ?? '[]');
  for (const { side, history } of told) {
    const made = new RayHistory(page, side, history.batch, history.ray).document;
    test.equal(`history of ray ${history.ray} of batch ${history.batch} in ${side}`, firstDifference(made, history), null);
  }
  for (const value of [1, -0.1, 3.5e-41, 16777216, 0, Math.PI]) {
    const x = Math.fround(value);
    const [, sign, whole, digits, power] = hexFloat(x).match(/^(-?)0x([01])\.?([0-9a-f]*)p([+-]\d+)$/);
    test.equal(`${x} as hexadecimal`, (sign ? -1 : 1) * (Number(whole) + (digits ? parseInt(digits, 16) / 16 ** digits.length : 0)) * 2 ** Number(power), x);
  }
}

function testFirst(test, { page, selection }) {
  const first = page.divergences[0];
  test.equal('the first launch shown', selection.launch, page.first.launch);
  if (first) test.equal('the first divergence is told', shownText('said').includes(first.text), true);
  test.equal('its launch is named', shownText('where').includes(page.launches[page.first.launch].name), true);
}

const hasDifferences = (page, k) => (page.pool.get(page.launches[k].differences) ?? []).some((n) => n > 0);
// The place in its level of the first node whose queue has another length; -1: none.
const otherLength = (page, k) => {
  const [a, b] = ['counts', 'counts_b'].map((name) => page.pool.get(page.launches[k][name]) ?? []);
  return b.length === 0 ? -1 : a.findIndex((n, i) => n !== b[i]);
};

// Launches that can be looked into, not too many, and the first whose queues differ in entries and in length.
const looked = (page) => page.launches.flatMap((l, k) => (isLevelKernel(l) && page.embedded(k) && l.verdict !== 'missing' ? [k] : []))
  .filter((k, i, all) => k === page.first.launch || i % Math.ceil(all.length / 2) === 0 || k === all.find((other) => hasDifferences(page, other)) || k === all.find((other) => otherLength(page, other) >= 0));

function testTime(test, { page, selection, panes }) {
  const timeline = panes.find((pane) => pane instanceof Timeline);
  const canvas = timeline.canvas;
  const context = canvas.getContext('2d');
  selection.select({ launch: page.launches.length - 1 });
  for (const k of looked(page)) {
    test.equal(`launch ${k}: its colour in the timeline says whether it failed`,
      inkBytes(context, k * timeline.step + timeline.step / 4, timeline.base - 4) === bytesText(inks().fault), page.failed(k));
    clickAt(canvas, (k + 0.5) * timeline.step, 50);
    test.equal(`launch ${k}: a click in the timeline`, addressHas('launch'), String(page.launches[k].launch));
    selection.select({ launch: page.launches.length - 1 });
  }
}

function testHeat(test, { page, selection, panes }) {
  const heat = panes.find((pane) => pane instanceof Heat);
  const context = heat.canvas.getContext('2d');
  for (const k of looked(page)) {
    const column = heat.columns.findIndex((c) => c.launches.includes(k));
    const { level } = page.launches[k];
    const y = heat.top + level * heat.row + heat.row / 2;
    clickAt(heat.canvas, heat.left + (column + 0.4) * heat.cell, y);
    test.equal(`launch ${k}: a click in the map`, selection.launch, k);
    test.equal(`launch ${k}: and a node of its level`, page.tree.level(selection.node), level);
    const differences = page.pool.get(page.launches[k].differences);
    const at = differences ? differences.findIndex((n) => n > 0) : -1;
    if (at < 0) continue;
    document.querySelector('#heat-kind input[value=differences]').click();
    const bins = heat.bins(differences.length);
    const bin = Math.floor(((at + 0.5) * bins) / differences.length);
    test.equal(`launch ${k}: a difference in the map`, inkBytes(context, heat.left + column * heat.cell + ((bin + 0.5) * (heat.cell - 3)) / bins, y), bytesText(inks().fault));
    test.equal('what the map shows is in the address', addressHas('heat'), 'differences');
    document.querySelector('#heat-kind input[value=entries]').click();
  }
}

function testTree(test, { page, selection }) {
  for (const k of looked(page)) {
    selection.select({ launch: k });
    const { level } = page.launches[k];
    const other = otherLength(page, k);
    if (other >= 0) selection.select({ node: page.tree.levelBegins[level] + other });
    for (const row of document.querySelectorAll('#tree .node')) {
      const node = Number(row.dataset.node);
      const of = page.launches.findIndex((l) => isLevelKernel(l) && l.level === page.tree.level(node) && ['batch', 'bounce', 'light'].every((m) => l[m] === page.launches[k][m]));
      const count = (number) => page.pool.get(number)?.[node - page.tree.levelBegins[page.tree.level(node)]];
      const [a, b] = of < 0 ? [] : [count(page.launches[of].counts), count(page.launches[of].counts_b)];
      test.equal(`launch ${k}: the length of node ${node}`, row.querySelector('.count').textContent, a === undefined ? '–' : b === undefined || a === b ? String(a) : `${a} / ${b}`);
    }
    const node = selection.node;
    if (level > 0) {
      press('ArrowUp');
      test.equal(`launch ${k}: up the tree`, selection.node, page.tree.parents[node]);
      press('ArrowDown');
      test.equal(`launch ${k}: and down`, page.tree.parents[selection.node], page.tree.parents[node]);
    }
  }
}

function testTable(test, { page, selection, panes }) {
  const pane = panes.find((p) => p instanceof QueuePane);
  for (const k of looked(page)) {
    selection.select({ launch: k });
    const { length } = pane.rows;
    const drawn = () => [...document.querySelectorAll('#queue tbody tr[data-ray]')];
    pane.box.scrollTop = 0;
    pane.drawRows();
    test.equal(`launch ${k}: rows in sight`, drawn().length <= 40 && drawn().length >= Math.min(length, 8), true);
    if (length === 0) continue;
    pane.box.scrollTop = pane.box.scrollHeight;
    pane.drawRows();
    const last = drawn().at(-1);
    test.equal(`launch ${k}: the last entry`, Number(last.dataset.ray), pane.rayOf(pane.rows.at(-1)));
    testRow(test, page, selection, pane, k, last);
    const differences = page.pool.get(page.launches[k].differences);
    const at = differences ? differences.findIndex((n) => n > 0) : -1;
    if (at < 0) continue;
    selection.select({ node: page.tree.levelBegins[page.launches[k].level] + at });
    const marked = pane.rows.flatMap(({ change }, i) => (['missing', 'extra', 'changed'].includes(change) ? [i] : []));
    test.equal(`launch ${k}: entries that are marked`, marked.length, differences[at]);
    pane.box.scrollTop = (marked[0] ?? 0) * rowHeight;
    pane.drawRows();
    const { change } = pane.rows[marked[0] ?? 0];
    test.equal(`launch ${k}: one is marked as ${change}`, drawn().some((r) => r.cells[0].textContent === change), true);
  }
}
function testRow(test, page, selection, pane, k, row) {
  const ray = Number(row.dataset.ray);
  const cells = () => Object.fromEntries(pane.columns.map(([name], i) => [name, row.cells[i].firstChild?.textContent ?? '']));
  const from = page.provenance[selection.at.batch];
  if (from && ray < from.pixel.length) {
    test.equal(`launch ${k}: the pixel of ray ${ray}`, cells().pixel.split(' #')[0], `${from.pixel[ray] % page.width}, ${Math.floor(from.pixel[ray] / page.width)}`);
  }
  const rays = page.pool.get(page.launches[k].arrays.rays);
  if (pane.rows.at(-1).a === null || 8 * ray >= rays.length) return;
  test.equal(`launch ${k}: the direction of ray ${ray}`, Math.fround(Number(cells()['direction y'].replace('∞', 'Infinity'))), rays[8 * ray + 5]);
}

function testBlock(test, { page, selection, panes }) {
  const pane = panes.find((p) => p instanceof BlockPane);
  const context = pane.canvas.getContext('2d');
  for (const k of looked(page)) {
    selection.select({ launch: k });
    const { block } = pane;
    if (!block || block.rows[0].base === undefined) continue;
    const row = block.rows.findIndex((r) => r.count > 0);
    if (row < 0) continue;
    const { hit, base, node, bad } = block.rows[row];
    const thread = hit.indexOf(true);
    const below = selection.run.below(k, node, block.rays[thread]);
    const corner = [pane.left + thread * pane.cell + 1, pane.top + row * pane.row + 1];
    test.equal(`launch ${k}: what thread ${thread} says`, pane.title(corner[0] + 1, corner[1]).includes(`entry ${below.position} = ${base} + ${below.position - base}`), true);
    if (thread !== block.chosen) {
      test.equal(`launch ${k}: its cell is filled`, inkBytes(context, ...corner), bytesText(bad[thread] ? inks().fault : mix(inks().panel, inks().accent, 0.75)));
    }
  }
}

function testSpace(test, { selection, panes, page }) {
  const pane = panes.find((p) => p instanceof SpacePane);
  selection.select({ launch: looked(page)[0] });
  const before = pane.canvas.toDataURL();
  clickAt(pane.canvas, 100, 100, 'pointerdown');
  clickAt(pane.canvas, 160, 120, 'pointermove');
  clickAt(pane.canvas, 160, 120, 'pointerup');
  test.equal('dragging turns the box', pane.canvas.toDataURL() !== before, true);
  const box = page.tree.box(selection.shown);
  const project = pane.view(box, 300, 300);
  const all = Array.from({ length: 8 }, (_, i) => project(corner(box, i))).flat();
  test.equal('the box fits', all.every((p) => p >= 0 && p <= 300), true);
}

function testImage(test, { page, selection }) {
  const canvas = document.getElementById('picture');
  if (canvas.hidden) return;
  const [x, y] = [page.width >> 1, page.height >> 2];
  const box = canvas.getBoundingClientRect();
  clickAt(canvas, ((x + 0.5) * box.width) / page.width, ((y + 0.5) * box.height) / page.height);
  const raw = page.provenance[selection.at.batch];
  const rays = [...raw.pixel.keys()].filter((ray) => raw.pixel[ray] === y * page.width + x);
  test.equal('a click on the image', addressHas('pixel'), `${x},${y}`);
  test.equal('chooses the first of its rays', selection.ray, rays[0] ?? null);
  test.equal('and tells how many', shownText('picture-note').includes(`pixel ${x}, ${y}: ${rays.length} ray`), true);
  selection.select({ launch: page.launches.length - 1, pixel: [0, 0] }); // reads no queue: nothing is dimmed
  const scale = canvas.width / page.width;
  const drawn = [...canvas.getContext('2d').getImageData((x + 0.5) * scale, (y + 0.5) * scale, 1, 1).data].slice(0, 3).join();
  const image = page.pool.get(page.images[selection.side]);
  test.equal('its colour', drawn, [0, 1, 2].map((c) => srgbByte(image[3 * (y * page.width + x) + c])).join());
}

function testChecks(test, { page, selection }) {
  const all = page.launches.map((launch) => launch.invariants.a.length + launch.invariants.b.length);
  [all.findIndex((n) => n === 0), all.findIndex((n) => n > 0)].filter((k) => k >= 0).forEach((k) => {
    const launch = page.launches[k];
    const broken = all[k];
    selection.select({ launch: k });
    const fails = [...document.querySelectorAll('.invariants td')].filter((cell) => cell.textContent.startsWith('fails')).length;
    const names = (side) => new Set(launch.invariants[side].map((f) => f.name)).size;
    test.equal(`launch ${k}: invariants that fail`, fails, names('a') + names('b'));
    if (broken > 0) test.equal(`launch ${k}: what failed is said`, shownText('checks').includes([...launch.invariants.a, ...launch.invariants.b][0].text), true);
  });
}

// l and s against what is counted here anew, by keys and by buttons, with the address after each.
function testJumps(test, { page, selection }) {
  const bad = page.launches.flatMap((launch, k) => (launch.differs === true || launch.verdict === 'missing'
    || launch.invariants.a.length + launch.invariants.b.length > 0 ? [k] : []));
  if (bad.length === 0) return;
  const kernel = (k) => page.launches[k].name.split('/').pop();
  const click = (id) => document.getElementById(id).click();
  selection.select({ launch: bad[0], node: null, ray: null });
  const another = bad.length > 1 ? bad[1] : bad[0];
  press('l');
  test.equal('l is the next launch that differs', selection.launch, another);
  test.equal('and the address says so', addressHas('launch'), String(page.launches[another].launch));
  press('L');
  test.equal('L is the one before', selection.launch, bad[0]);
  click('next-launch');
  test.equal('the button is l', selection.launch, another);
  click('previous-launch');
  const next = bad.find((k) => kernel(k) !== kernel(bad[0]));
  press('s');
  test.equal('s is the next kernel that differs', selection.launch, next ?? bad[0]);
  if (next !== undefined) {
    test.equal('and the address has its launch', addressHas('launch'), String(page.launches[next].launch));
    selection.select({ launch: bad[0], node: null, ray: null });
    click('next-stage');
    test.equal('the button is s', selection.launch, next);
    press('S');
    test.equal('S goes back to another kernel', kernel(selection.launch) !== kernel(next), true);
  }
  selection.select({ launch: 0, node: null, ray: null });
}

function testKeys(test, { page, selection }) {
  selection.select({ launch: 0, node: null, ray: null });
  press('ArrowRight');
  test.equal('→ is the next launch', selection.launch, Math.min(1, page.launches.length - 1));
  press('ArrowLeft');
  test.equal('← the one before', selection.launch, 0);
  press('x');
  test.equal('x shows floats as hexadecimal', addressHas('float'), 'hex');
  press('x');
  if (page.divergences.length > 0) {
    press('n');
    test.equal('n is the first divergence', selection.launch, page.divergences[0].launch);
    press('n');
    test.equal('n again the second', selection.divergence, Math.min(1, page.divergences.length - 1));
    press('N');
    test.equal('N goes back', selection.divergence, 0);
  }
  testJumps(test, { page, selection });
  if (page.runs.b) {
    const { side } = selection;
    press('b');
    test.equal('b is the other run', addressHas('side') ?? 'a', side === 'a' ? 'b' : 'a');
    press('b');
  }
  press('?');
  test.equal('? shows the keys', document.getElementById('help').open, true);
  document.getElementById('help').close();
}

function testAddress(test, { page, selection }) {
  const k = looked(page).at(-1);
  selection.select({ launch: k, node: null });
  selection.select({ ray: selection.run.index(k).queue[0] ?? null, float: 'hex' });
  const [address, node, ray] = [location.hash, selection.node, selection.ray];
  selection.select({ launch: 0, ray: null, float: 'decimal' });
  history.replaceState(null, '', address);
  dispatchEvent(new PopStateEvent('popstate'));
  test.equal('the address brings back the launch', selection.launch, k);
  test.equal('and the node', selection.node, node);
  test.equal('and the ray', selection.ray, ray);
  test.equal('and how floats are shown', selection.float, 'hex');
  history.replaceState(null, '', '#selftest&launch=999999&node=999999&ray=x&pixel=9');
  dispatchEvent(new PopStateEvent('popstate'));
  test.equal('an address of nothing shows the first', selection.launch, page.first.launch);
}

function testEmbedded(test, { page, selection }) {
  const k = page.launches.findIndex((_, i) => !page.embedded(i));
  test.equal('counts of all queues are there', page.launches.every((l) => !isLevelKernel(l) || page.pool.get(l.counts).length > 0), true);
  if (k < 0) return;
  selection.select({ launch: k });
  test.equal('what is not embedded has its command', shownText('unembedded').includes(`--launch ${page.launches[k].launch} --html`), true);
}

async function queuesSelfTest() {
  const test = new SelfTest();
  try {
    const debug = await started;
    for (const part of [testFirst, testArrays, testHistories, testTime, testHeat, testTree, testTable, testBlock, testSpace, testImage, testChecks, testKeys, testAddress, testEmbedded]) part(test, debug);
  } catch (error) {
    test.failed.push(`${error}`);
  }
  test.write();
}
if (stateFromAddress().selftest !== undefined) queuesSelfTest();

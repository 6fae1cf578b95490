'use strict';
// The page of the live view: gestures to messages, frames to the picture.

const picture = byId('picture');
const overlay = byId('overlay');
const view = { camera: null, header: null, path: null, undo: [], flying: new Set(), lastCamera: 0, dragging: false, focus: false, times: [] };

function announce(text) { byId('announced').textContent = text; }
function problem(text) {
  byId('problem').hidden = !text;
  byId('problem').textContent = text;
}

// ---- From the program ----

function sceneDistance(camera) {
  const { low, high } = view.scene;
  const middle = times(add(low, high), 0.5);
  const along = dot(sub(middle, camera.position), camera.forward);
  return Math.max(along, 0.05 * size(sub(high, low)), 1e-6);
}

// Frames that are older than the last message from here show a camera that has been left since.
function takeCamera({ camera, shows }) {
  if (!view.scene || view.dragging || view.flying.size || shows < view.lastCamera) return;
  const now = view.camera;
  const same = now && size(sub(now.position, camera.position)) <= 1e-5 * (1 + size(camera.position)) && dot(now.forward, camera.forward) > 1 - 1e-9 && Math.abs(Math.tan(now.fov * degrees / 2) - camera.tan_half_fov) < 1e-5;
  if (same) return;
  view.camera = OrbitCamera.from(camera, now && view.path ? now.distance : sceneDistance(camera));
  showFov();
}

function showFov() {
  byId('fov').value = Math.round(view.camera.fov);
  byId('fov-value').textContent = `${view.camera.fov.toFixed(1)}°`;
}

function fitFrame(header) {
  const [width, height] = header.full;
  const room = Math.max(200, innerHeight - 150);
  byId('frame').style.aspectRatio = `${width} / ${height}`;
  byId('frame').style.maxWidth = `${Math.round(room * width / height)}px`;
}

const heard = {
  hello(message) {
    view.scene = message.scene;
    view.lastCamera = 0;
    document.title = `${message.scene.name} – scotty view`;
    byId('scene').textContent = message.scene.name;
    byId('about').textContent = `${message.scene.triangles.toLocaleString('en')} triangles · scotty ${message.version}`;
    const names = message.scene.cameras;
    byId('cameras').replaceChildren(new Option('choose', ''), ...names.map((name, i) => new Option(name, String(i))));
    byId('cameras-field').hidden = names.length < 2;
    controls.hello(message);
  },
  state(message) {
    view.state = message;
    controls.state(message);
    byId('connection').textContent = `connected, ${message.viewers} ${message.viewers === 1 ? 'viewer' : 'viewers'}`;
  },
  changed(message) { controls.changed(message); announce(message.text); },
  error(message) { view.compareAsked = false; problem(message.text); announce(message.text); },
  failed(message) { problem(message.text); },
  path(message) {
    if (view.focus) {
      view.focus = false;
      if (message.vertices.length) {
        remember();
        view.camera.turnTo(message.vertices[0].position);
        sendCamera(false);
      }
      return;
    }
    view.path = message;
    showPath(message);
    redrawPath();
    announce(`path of pixel ${message.x},${message.y}: ${message.vertices.length} vertices`);
  },
  job(message) { (jobs[message.job] ?? (() => {}))(message); },
};

const jobWords = { running: 'is running', passed: 'passed', failed: 'FAILED', stopped: 'was stopped', broken: 'could not be carried out' };
const lastLine = (text) => (text ?? '').trim().split('\n').pop();
const jobs = {
  verify(message) {
    const running = message.state === 'running';
    byId('verify-stop').disabled = !running;
    byId('verify-start').disabled = running;
    byId('verify-said').textContent = running ? `verifying at ${message.size} …` : `verification ${jobWords[message.state]}`;
    byId('verify-said').className = message.state === 'failed' || message.state === 'broken' ? 'fault' : '';
    byId('verify-link').hidden = !message.link;
    byId('verify-output').hidden = running;
    byId('verify-output').textContent = message.output ?? '';
  },
  queues(message) {
    const running = message.state === 'running';
    byId('queues-start').disabled = running;
    byId('queues-said').textContent = running ? `capturing this view at ${message.size} …`
      : message.link ? `captured at ${message.size}, at pixel ${message.pixel}` : `the capture ${jobWords[message.state]}: ${lastLine(message.output)}`;
    byId('queues-link').hidden = !message.link;
  },
  compare(message) {
    const running = message.state === 'running';
    byId('compare-start').disabled = running;
    view.compareAsked = false;
    byId('compare-said').textContent = running ? `rendering ${message.a} and ${message.b} …` : (message.text ?? `the comparison ${jobWords[message.state]}: ${lastLine(message.output)}`);
    byId('compare-said').className = message.different > 0 ? 'fault' : '';
    if (message.state !== 'passed') return;
    byId('compared').hidden = false;
    byId('compare-a-name').textContent = message.a;
    byId('compare-b-name').textContent = message.b;
    for (const name of ['a', 'b', 'difference']) byId(`compare-${name}`).src = `compare/${name}.png?${performance.now()}`;
    compareIfLive(); // the camera may have moved meanwhile
  },
};

function seen(header, bitmaps) {
  view.header = header;
  fitFrame(header);
  if (picture.width !== header.width || picture.height !== header.height) {
    picture.width = header.width;
    picture.height = header.height;
  }
  const context = picture.getContext('2d');
  let row = 0;
  bitmaps.forEach((bitmap) => {
    context.drawImage(bitmap, 0, row);
    row += bitmap.height;
    bitmap.close();
  });
  takeCamera(header);
  const now = performance.now();
  view.times = view.times.filter((t) => now - t < 1000).concat(now);
  byId('said').textContent = frameText(header, view.times.length > 1 ? view.times.length : 0, link.latency);
  const { legend } = header;
  byId('legend').hidden = !legend;
  if (legend) byId('legend').replaceChildren(`${Number(legend.low.toPrecision(4))} `, element('span', { className: 'scale' }), ` ${Number(legend.high.toPrecision(4))} ${legend.unit}${legend.logarithmic ? ', logarithmic' : ''}`);
  redrawPath();
  if (!view.numbersDue || now >= view.numbersDue) {
    view.numbersDue = now + 250;
    showNumbers(header);
    drawChart(byId('chart'), header.statistics?.queues ?? []);
  }
  if (header.rest && header.samples === header.target && view.restedAt !== header.state) {
    view.restedAt = header.state;
    announce(`${header.samples} samples: the picture is complete`);
  }
  compareIfLive();
}

function redrawPath() { drawPath(overlay, view.path, view.header?.camera); }

const link = new ViewLink({
  heard: (message) => { if (Object.hasOwn(heard, message.type)) heard[message.type](message); },
  seen,
  changed: (text) => { byId('connection').textContent = text; },
});
const send = (message) => { problem(''); return link.send(message); };
const controls = new Controls(send);

// ---- Camera ----

// One message a picture of the screen, whatever a mouse sends.
function sendCamera(moving) {
  showFov();
  if (!moving) {
    cancelAnimationFrame(view.pending);
    view.pending = 0;
    view.lastCamera = send(view.camera.message(false));
    return;
  }
  if (view.pending) return;
  view.pending = requestAnimationFrame(() => {
    view.pending = 0;
    view.lastCamera = send(view.camera.message(true));
  });
}

function remember() {
  view.undo.push(view.camera.copy());
  if (view.undo.length > 200) view.undo.shift();
}

// A single step: it rests at once, or when the last of a quick row has come.
function step(move) {
  if (!view.camera) return;
  if (!view.settling) remember();
  move(view.camera);
  sendCamera(true);
  clearTimeout(view.settling);
  view.settling = setTimeout(() => { view.settling = 0; sendCamera(false); }, 150);
}

function undo() {
  const before = view.undo.pop();
  if (!before) return announce('there is no camera before this one');
  view.camera = before;
  sendCamera(false);
}
const frameAll = () => { if (view.camera) remember(); view.lastCamera = send({ type: 'frame all' }); };
const ownCamera = (which = {}) => { if (view.camera) remember(); view.lastCamera = send({ type: 'own camera', ...which }); };
byId('all').addEventListener('click', frameAll);
byId('own').addEventListener('click', () => ownCamera());
byId('cameras').addEventListener('change', () => {
  const chosen = byId('cameras').value;
  if (chosen !== '') ownCamera({ number: Number(chosen) });
  byId('cameras').value = '';
});
byId('undo').addEventListener('click', undo);
byId('fov').addEventListener('input', () => step((camera) => camera.setFov(Number(byId('fov').value))));

// ---- Mouse and touch ----

const pointers = new Map();
function pixelAt(event) {
  const box = picture.getBoundingClientRect();
  const [width, height] = view.header.full;
  const x = Math.floor((event.clientX - box.left) / box.width * width);
  const y = Math.floor((event.clientY - box.top) / box.height * height);
  return { x: Math.max(0, Math.min(width - 1, x)), y: Math.max(0, Math.min(height - 1, y)) };
}
const middle = () => ({ x: view.header.full[0] >> 1, y: view.header.full[1] >> 1 });
function pick(pixel, focus) {
  view.focus = focus;
  send({ type: 'pick', ...pixel });
}

picture.addEventListener('pointerdown', (event) => {
  if (!view.camera || !view.header) return;
  picture.focus({ preventScroll: true });
  if (event.isTrusted) picture.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  if (pointers.size === 1) {
    view.dragging = true;
    view.moved = 0;
    view.button = event.button;
    remember();
  }
});

picture.addEventListener('pointermove', (event) => {
  const last = pointers.get(event.pointerId);
  if (!last || !view.camera) return;
  const height = picture.getBoundingClientRect().height;
  const dx = (event.clientX - last.x) / height;
  const dy = (event.clientY - last.y) / height;
  view.moved += Math.abs(event.clientX - last.x) + Math.abs(event.clientY - last.y);
  if (pointers.size === 2) {
    const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const before = Math.hypot(last.x - other.x, last.y - other.y);
    const after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
    if (before > 0 && after > 0) view.camera.dolly(before / after);
    view.camera.pan(dx / 2, dy / 2);
  } else if (view.moved > 3) {
    if (event.shiftKey || view.button === 1) view.camera.pan(dx, dy);
    else if (view.button === 2) view.camera.dolly(Math.exp(2 * dy));
    else view.camera.orbit(-3 * dx, 3 * dy);
  }
  last.x = event.clientX;
  last.y = event.clientY;
  if (view.moved > 3) sendCamera(true);
});

function release(event) {
  if (!pointers.delete(event.pointerId) || pointers.size > 0) return;
  view.dragging = false;
  if (view.moved > 3) return sendCamera(false);
  view.undo.pop();
  if (event.type === 'pointerup' && view.button === 0) pick(pixelAt(event), false);
}
picture.addEventListener('pointerup', release);
picture.addEventListener('pointercancel', release);
picture.addEventListener('contextmenu', (event) => event.preventDefault());
picture.addEventListener('dblclick', (event) => { if (view.header) pick(pixelAt(event), true); });
picture.addEventListener('wheel', (event) => {
  event.preventDefault();
  step((camera) => camera.dolly(Math.exp(Math.max(-0.5, Math.min(0.5, event.deltaY / 500)))));
}, { passive: false });

// ---- Keys ----

const typing = (target) => target.closest('input:not([type=checkbox]), select, textarea, dialog') !== null;
const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const flights = { w: [0, 0, 1], s: [0, 0, -1], a: [-1, 0, 0], d: [1, 0, 0], q: [0, -1, 0], e: [0, 1, 0] };

function fly(then) {
  if (!view.flying.size) {
    view.flight = 0;
    sendCamera(false);
    return;
  }
  const now = performance.now();
  const metres = Math.min(0.1, (now - then) / 1000) * 0.5 * size(sub(view.scene.high, view.scene.low));
  const by = [...view.flying].map((key) => flights[key]).reduce(add, [0, 0, 0]);
  view.camera.fly(...times(by, metres));
  sendCamera(true);
  view.flight = requestAnimationFrame(() => fly(now));
}

const keys = {
  '+': () => step((camera) => camera.dolly(0.9)),
  '=': () => step((camera) => camera.dolly(0.9)),
  '-': () => step((camera) => camera.dolly(1 / 0.9)),
  '[': () => step((camera) => camera.setFov(camera.fov / 1.1)),
  ']': () => step((camera) => camera.setFov(camera.fov * 1.1)),
  f: frameAll,
  o: () => ownCamera(),
  u: undo,
  p: () => pick(middle(), false),
  c: () => pick(middle(), true),
  b: () => send({ type: 'show', filtered: !view.state.filtered }),
  ',': () => send({ type: 'show', exposure: view.state.exposure - 0.5 }),
  '.': () => send({ type: 'show', exposure: view.state.exposure + 0.5 }),
  '?': () => byId('help').showModal(),
};

document.addEventListener('keydown', (event) => {
  if (typing(event.target) || event.ctrlKey || event.metaKey || event.altKey || !view.camera || !view.state || !view.header) return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (arrows[key]) {
    const [x, y] = arrows[key];
    step((camera) => (event.shiftKey ? camera.pan(-0.05 * x, 0.05 * y) : camera.orbit(0.08 * x, 0.08 * y)));
  } else if (flights[key]) {
    if (!view.flying.size) remember();
    view.flying.add(key);
    if (!view.flight) fly(performance.now() - 20); // a short press is a short step
  } else if (keys[key]) {
    keys[key]();
  } else if (/^[1-7]$/.test(key)) {
    send({ type: 'show', what: byId('what').options[Number(key) - 1].value });
  } else {
    return;
  }
  event.preventDefault();
});
document.addEventListener('keyup', (event) => view.flying.delete(event.key.toLowerCase()));
addEventListener('blur', () => view.flying.clear());
addEventListener('resize', () => { if (view.header) { fitFrame(view.header); redrawPath(); } });
byId('help-button').addEventListener('click', () => byId('help').showModal());

// ---- Beside the picture ----

// What was said of the job before is not said of this one.
function startJob(job, members = {}) {
  byId(`${job}-said`).textContent = '';
  byId(`${job}-said`).className = '';
  send({ type: 'start', job, ...members });
}

byId('verify-start').addEventListener('click', () => startJob('verify'));
byId('verify-stop').addEventListener('click', () => send({ type: 'stop', job: 'verify' }));
byId('queues-start').addEventListener('click', () => { if (view.path) startJob('queues', { x: view.path.x, y: view.path.y }); });
function startCompare() {
  view.comparedAt = view.header?.state;
  view.compareAsked = true; // until the program has answered
  startJob('compare', { backend: byId('compare-backend').value, plant: byId('compare-plant').value.trim(), own_plant: byId('compare-own-plant').value.trim() });
}
function compareIfLive() {
  const free = !view.compareAsked && !byId('compare-start').disabled;
  if (free && byId('compare-live').checked && view.comparedAt !== view.header?.state) startCompare();
}
byId('compare-start').addEventListener('click', startCompare);

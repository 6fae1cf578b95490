'use strict';
// What is drawn over the picture: the path of a pixel; and the chart of queue lengths.

const pathColor = '#ffd24a';
const freeLight = '#7fe08a';
const blockedLight = '#ff7f88';

// path: as the program says it; camera: of the frame that is shown.
function drawPath(canvas, path, camera) {
  const box = canvas.getBoundingClientRect();
  const scale = devicePixelRatio || 1;
  canvas.width = Math.round(box.width * scale);
  canvas.height = Math.round(box.height * scale);
  const context = canvas.getContext('2d');
  context.clearRect(0, 0, canvas.width, canvas.height);
  if (!path || !camera) return;
  const at = (point) => {
    const seen = projected(point, camera, canvas.width / canvas.height);
    return seen && [seen[0] * canvas.width, seen[1] * canvas.height];
  };
  const line = (from, to, color, dashes = []) => {
    const [a, b] = [at(from), at(to)];
    if (!a || !b) return;
    for (const [width, ink] of [[4, '#000a'], [2, color]]) {
      context.lineWidth = width * scale;
      context.strokeStyle = ink;
      context.setLineDash(dashes.map((dash) => dash * scale));
      context.beginPath();
      context.moveTo(...a);
      context.lineTo(...b);
      context.stroke();
    }
    context.setLineDash([]);
  };
  let last = null;
  path.vertices.forEach((vertex, number) => {
    for (const light of vertex.lights) line(vertex.position, light.end, light.blocked ? blockedLight : freeLight, [5, 4]);
    if (last) line(last, vertex.position, pathColor);
    last = vertex.position;
    const spot = at(vertex.position);
    if (!spot) return;
    context.beginPath();
    context.arc(...spot, 5 * scale, 0, 2 * Math.PI);
    context.fillStyle = pathColor;
    context.fill();
    context.strokeStyle = '#000';
    context.lineWidth = scale;
    context.stroke();
    context.font = `${12 * scale}px sans-serif`;
    context.lineWidth = 3 * scale;
    context.strokeText(String(number), spot[0] + 8 * scale, spot[1] - 6 * scale);
    context.fillText(String(number), spot[0] + 8 * scale, spot[1] - 6 * scale);
  });
  if (last && path.escape) line(last, add(last, times(path.escape, size(sub(last, path.origin)))), pathColor, [2, 6]);
}

function showPath(path) {
  byId('pixel-note').textContent = `Pixel ${path.x},${path.y}: ray ${path.ray} of batch ${path.batch}, ${path.vertices.length} vertices${path.escape ? ', then out of the scene' : ''}. Green: light that arrives; red: light that is blocked.`;
  byId('path').hidden = path.vertices.length === 0;
  byId('queues-line').hidden = false;
  fillTable(byId('path'), path.vertices.map((v, i) => [String(i), v.distance.toPrecision(4), String(v.primitive), v.material,
    v.lights.length ? `${v.lights.filter((l) => !l.blocked).length} of ${v.lights.length} free` : '–']));
}

const chartKinds = ['primary', 'bounce', 'shadow'];

// Bars by level, the kinds of rays beside each other.
function drawChart(canvas, queues) {
  const box = canvas.getBoundingClientRect();
  const scale = devicePixelRatio || 1;
  canvas.width = Math.max(1, Math.round(box.width * scale));
  canvas.height = Math.max(1, Math.round(box.height * scale));
  const context = canvas.getContext('2d');
  const levels = Math.max(0, ...queues.map((lengths) => lengths.length));
  const most = Math.max(1, ...queues.flat());
  if (levels === 0) {
    byId('chart-text').textContent = 'no queues in this picture';
    return;
  }
  const style = getComputedStyle(document.documentElement);
  const inks = ['--accent', '--quiet', '--line'].map((name) => style.getPropertyValue(name));
  const room = canvas.width / levels;
  for (let level = 0; level < levels; ++level) {
    queues.forEach((lengths, kind) => {
      const height = ((lengths[level] ?? 0) / most) * (canvas.height - 14 * scale);
      context.fillStyle = inks[kind];
      context.fillRect((level + (0.1 + 0.27 * kind)) * room, canvas.height - 14 * scale - height, 0.25 * room, height);
    });
    context.fillStyle = style.getPropertyValue('--quiet');
    context.font = `${10 * scale}px sans-serif`;
    context.fillText(String(level), (level + 0.4) * room, canvas.height - 2 * scale);
  }
  const said = chartKinds.map((kind, k) => (queues[k].length ? `${kind}: ${queues[k].map(rate).join(', ')}` : '')).filter(Boolean);
  byId('chart-text').textContent = `Entries by level. ${said.join('; ')}`;
}

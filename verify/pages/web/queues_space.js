'use strict';
// The node in space: its box, its children's boxes, the triangles below it, the rays in its queue. Drag to turn.

const edges = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];
const corner = (box, i) => [box[i & 1 ? 3 : 0], box[i & 2 ? 4 : 1], box[i & 4 ? 5 : 2]];

// The part of a line inside a box, as [from, to], or null. It is for drawing only: the model says what a ray enters.
function inside(box, origin, direction, from, to) {
  for (let axis = 0; axis < 3; ++axis) {
    const [a, b] = [0, 3].map((side) => (box[axis + side] - origin[axis]) / direction[axis]);
    if (Number.isNaN(a) || Number.isNaN(b)) continue;
    from = Math.max(from, Math.min(a, b));
    to = Math.min(to, Math.max(a, b));
  }
  return from <= to ? [from, to] : null;
}

class SpacePane {
  constructor(at, page, selection) {
    Object.assign(this, { canvas: at.space, note: at['space-note'], key: at['space-key'], page, selection, yaw: 0.6, pitch: 0.35, most: 400 });
    const { canvas } = this;
    let last = null;
    canvas.addEventListener('pointerdown', (event) => { last = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener('pointermove', (event) => {
      if (!last) return;
      this.turn((event.clientX - last[0]) / 120, (event.clientY - last[1]) / 120);
      last = [event.clientX, event.clientY];
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => { last = null; });
    canvas.addEventListener('dblclick', () => { this.yaw = 0.6; this.pitch = 0.35; this.draw(); });
  }
  turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.min(1.5, Math.max(-1.5, this.pitch + pitch));
    this.draw();
  }

  // Orthographic, about the middle of the box, which always fits.
  view(box, width, height) {
    const middle = [0, 1, 2].map((axis) => (box[axis] + box[axis + 3]) / 2);
    const radius = Math.max(1e-30, Math.hypot(...[0, 1, 2].map((axis) => (box[axis + 3] - box[axis]) / 2)));
    const scale = (0.46 * Math.min(width, height)) / radius;
    const [sy, cy, sp, cp] = [Math.sin(this.yaw), Math.cos(this.yaw), Math.sin(this.pitch), Math.cos(this.pitch)];
    return ([x, y, z]) => {
      const [a, b, c] = [x - middle[0], y - middle[1], z - middle[2]];
      const depth = -a * sy + c * cy;
      return [width / 2 + scale * (a * cy + c * sy), height / 2 - scale * (b * cp - depth * sp)];
    };
  }

  draw() {
    const { canvas, page, selection } = this;
    const height = Math.max(240, Math.min(canvas.clientWidth * 0.8, 380));
    const context = fitted(canvas, height);
    const node = selection.shown ?? selection.node ?? 0;
    const { tree } = page;
    const ink = inks();
    const box = tree.box(node);
    const project = this.view(box, canvas.clientWidth, height);
    const line = (a, b) => { context.moveTo(...project(a)); context.lineTo(...project(b)); };
    const drawBox = (of, style, width) => {
      context.strokeStyle = style;
      context.lineWidth = width;
      context.beginPath();
      for (const [i, j] of edges) line(corner(of, i), corner(of, j));
      context.stroke();
    };
    this.drawTriangles(context, ink, node, project);
    const visit = this.visitOfSelected();
    const met = visit?.children?.filter((child) => child.position !== null).map((child) => child.node) ?? [];
    const bad = visit?.children?.filter((child) => child.outcome === 'lost' || child.outcome === 'extra').map((child) => child.node) ?? [];
    for (const child of tree.childrenOf(node)) {
      drawBox(tree.box(child), bad.includes(child) ? ink.fault : mix(ink.paper, ink.accent, met.includes(child) ? 1 : 0.45), met.includes(child) || bad.includes(child) ? 1.75 : 1);
    }
    drawBox(box, ink.ink, 1.25);
    const rays = this.drawRays(context, ink, node, box, line, project, visit);
    this.note.textContent = 'drag to turn';
    this.key.textContent = `Node ${node}${tree.isSubtree(node) ? ', a subtree' : tree.isLeaf(node) ? ', a leaf' : `, its ${tree.children[node]} children`}${rays}`;
  }
  visitOfSelected() {
    const { selection } = this;
    if (selection.ray === null || !selection.embedded || !selection.run.index(selection.launch)) return null;
    const at = selection.run.nodesWith(selection.launch, selection.ray).find(({ node }) => node === selection.shown);
    return at ? visitDocument(selection.run, selection.launch, at.node, at.position) : null;
  }
  drawTriangles(context, ink, node, project) {
    const { tree } = this.page;
    if (!tree.corners) return;
    context.strokeStyle = mix(ink.paper, ink.quiet, 0.4);
    context.lineWidth = 0.5;
    context.beginPath();
    for (const leaf of tree.under(node, 3000)) {
      for (let i = tree.firstTriangle[leaf]; i < tree.firstTriangle[leaf] + tree.triangles[leaf]; ++i) {
        const [a, b, c] = [0, 3, 6].map((k) => project(tree.corners.subarray(9 * i + k, 9 * i + k + 3)));
        context.moveTo(...a); context.lineTo(...b); context.lineTo(...c); context.closePath();
      }
    }
    context.stroke();
  }
  drawRays(context, ink, node, box, line, project, visit) {
    const { selection } = this;
    const { run, launch } = selection;
    if (selection.shown === null) return '; this launch reads no queues';
    if (!selection.embedded || !run.index(launch)) return '; its rays are not embedded';
    const length = run.length(launch, node);
    const stride = Math.max(1, Math.ceil(length / this.most));
    const segment = (ray) => {
      const r = run.record(launch, ray);
      if (!r || !(r[7] >= r[3])) return null; // a dead ray goes nowhere
      const [origin, direction] = [r.subarray(0, 3), r.subarray(4, 7)];
      const size = Math.hypot(...[0, 1, 2].map((axis) => box[axis + 3] - box[axis]));
      const way = inside(box, origin, direction, r[3], r[7]);
      if (!way) return null;
      const at = (t) => [0, 1, 2].map((axis) => origin[axis] + t * direction[axis]);
      const reach = size * 0.12 / Math.hypot(...direction);
      return [at(Math.max(r[3], way[0] - reach)), at(Math.min(r[7], way[1] + reach)), at];
    };
    context.strokeStyle = mix(ink.paper, ink.quiet, 0.9);
    context.globalAlpha = length / stride > 100 ? 0.25 : 0.5;
    context.lineWidth = 0.75;
    context.beginPath();
    let shown = 0;
    for (let p = 0; p < length; p += stride) {
      const found = segment(run.ray(launch, node, p));
      if (found) { line(found[0], found[1]); ++shown; }
    }
    context.stroke();
    context.globalAlpha = 1;
    const chosen = visit ? segment(selection.ray) : null;
    if (chosen) this.drawChosen(context, ink, line, project, chosen, visit);
    return ` and ${shown} of the ${length} rays in its queue${chosen ? `; ray ${selection.ray} stands out` : ''}`;
  }
  drawChosen(context, ink, line, project, [from, to, at], visit) {
    context.strokeStyle = ink.ink;
    context.lineWidth = 2;
    context.beginPath();
    line(from, to);
    context.stroke();
    const dot = (t, style) => {
      if (t === null || !Number.isFinite(Number(t))) return;
      context.fillStyle = style;
      context.beginPath();
      context.arc(...project(at(Number(t))), 3.5, 0, 2 * Math.PI);
      context.fill();
    };
    for (const child of visit.children ?? []) dot(child.entry, child.outcome === 'lost' ? ink.fault : ink.accent);
    if (visit.leaf?.closest) dot(visit.leaf.closest.t, ink.accent);
  }
}

'use strict';
// The image: a click chooses a pixel and its rays; pixels with rays in the queue stand out.

class ImagePane {
  constructor(at, page, selection) {
    Object.assign(this, { canvas: at.picture, note: at['picture-note'], kind: at['side-kind'], page, selection });
    this.kind.hidden = !page.runs.b;
    this.kind.addEventListener('change', (event) => selection.select({ side: event.target.value }, false));
    this.canvas.addEventListener('click', (event) => {
      const box = this.canvas.getBoundingClientRect();
      const along = (position, size, count) => Math.min(count - 1, Math.max(0, Math.floor((position / size) * count)));
      selection.select({ pixel: [along(event.clientX - box.left, box.width, page.width), along(event.clientY - box.top, box.height, page.height)] });
    });
  }
  inQueue() {
    const { page, selection } = this;
    const from = page.provenance[selection.at.batch];
    if (selection.shown === null || !selection.embedded || !from || !selection.run.index(selection.launch)) return null;
    const length = selection.run.length(selection.launch, selection.shown);
    const pixels = new Set();
    for (let p = 0; p < length; ++p) pixels.add(from.pixel[selection.run.ray(selection.launch, selection.shown, p)]);
    return pixels;
  }
  draw() {
    const { canvas, page, selection } = this;
    for (const input of this.kind.querySelectorAll('input')) input.checked = input.value === selection.side;
    const image = page.pool.get(page.images?.[selection.side]);
    canvas.hidden = !image;
    if (!image) { this.note.textContent = 'The image was not captured, or is too large to embed.'; return; }
    const inQueue = this.inQueue();
    const scale = Math.max(1, Math.ceil(480 / page.width));
    canvas.width = page.width * scale;
    canvas.height = page.height * scale;
    const context = canvas.getContext('2d');
    context.imageSmoothingEnabled = false;
    context.drawImage(imageCanvas(page.width, page.height, (i) => {
      const dim = inQueue && !inQueue.has(i) ? 0.3 : 1;
      return [0, 1, 2].map((c) => Math.round(dim * srgbByte(image[3 * i + c])));
    }), 0, 0, canvas.width, canvas.height);
    if (selection.pixel) {
      frame(context, selection.pixel[0] * scale, selection.pixel[1] * scale, scale, scale, 2);
    }
    const rays = selection.pixelRays.size;
    this.note.textContent = [selection.pixel ? `pixel ${selection.pixel.join(', ')}: ${rays} ray${rays === 1 ? '' : 's'}` : 'click a pixel for its rays',
      inQueue ? `${inQueue.size} pixels have rays in this queue` : ''].filter(Boolean).join('; ');
  }
}

'use strict';
// Drawing: a view of a case onto a canvas, marks on top, and magnifiers.

// An image as a canvas of its own size; color(i) gives the bytes of pixel i.
function imageCanvas(width, height, color) {
  const canvas = element('canvas', { width, height });
  const data = new ImageData(width, height);
  for (let i = 0; i < width * height; ++i) data.data.set([...color(i), 255], 4 * i);
  canvas.getContext('2d').putImageData(data, 0, 0);
  return canvas;
}

const shownSide = (one, view) => (view === 'golden' ? one.golden : one.new);

// Uses whole canvas pixels for each pixel of the image, so that edges are sharp; at least 1000 across.
function fitPicture(canvas, side) {
  const scale = Math.max(1, Math.ceil(1000 / side.width));
  canvas.width = side.width * scale;
  canvas.height = side.height * scale;
  return scale;
}

// A frame that is visible on any colour: dark outside, light inside.
function frame(context, x, y, width, height, line) {
  context.lineWidth = line;
  context.strokeStyle = '#000';
  context.strokeRect(x - 1.5 * line, y - 1.5 * line, width + 3 * line, height + 3 * line);
  context.strokeStyle = '#fff';
  context.strokeRect(x - line / 2, y - line / 2, width + line, height + line);
}

const faultColor = '#ff2d3d'; // one red on every picture, in light and dark

// Faulty pixels of the new image are filled, those of the golden image are hollow. Each gets a ring, because one pixel is
// easily overlooked.
function drawFaults(context, one, view, scale) {
  const sides = view === 'golden' ? [one.golden] : view === 'new' ? [one.new] : [one.new, one.golden];
  for (const side of sides) {
    for (let i = 0; i < side.width * side.height; ++i) {
      if (!faultyPixel(side.mean, i)) continue;
      const x = (i % side.width) * scale;
      const y = Math.floor(i / side.width) * scale;
      context.fillStyle = context.strokeStyle = faultColor;
      context.lineWidth = Math.max(2, scale / 8);
      if (side === one.new) context.fillRect(x, y, scale, scale);
      else context.strokeRect(x + 1, y + 1, scale - 2, scale - 2);
      context.beginPath();
      context.arc(x + scale / 2, y + scale / 2, Math.max(12, 1.6 * scale), 0, 2 * Math.PI);
      context.stroke();
    }
  }
}

// shown: { view, gain, split (0..1), overlay, pixel: [x, y], region: gate or null }
function drawPicture(canvas, one, shown) {
  const side = shownSide(one, shown.view);
  const scale = fitPicture(canvas, side);
  const context = canvas.getContext('2d');
  context.imageSmoothingEnabled = false;
  const paint = (view) => imageCanvas(side.width, side.height, (i) => viewColor(one, view, i, shown.gain));
  context.drawImage(paint(shown.view), 0, 0, canvas.width, canvas.height);
  if (shown.view === 'split') {
    const line = Math.round(shown.split * canvas.width);
    context.save();
    context.beginPath();
    context.rect(line, 0, canvas.width - line, canvas.height);
    context.clip();
    context.drawImage(paint('golden'), 0, 0, canvas.width, canvas.height);
    context.restore();
    context.fillStyle = '#000';
    context.fillRect(line - 3, 0, 6, canvas.height);
    context.fillStyle = '#fff';
    context.fillRect(line - 1, 0, 2, canvas.height);
  }
  if (shown.overlay) drawFaults(context, one, shown.view, scale);
  if (shown.region) {
    const { x, y, width, height } = shown.region;
    context.setLineDash([12, 8]);
    frame(context, x * scale, y * scale, width * scale, height * scale, 3);
    context.setLineDash([]);
  }
  frame(context, shown.pixel[0] * scale, shown.pixel[1] * scale, scale, scale, 2);
  return scale;
}

const magnified = 11; // pixels across, the chosen one in the middle

function drawMagnifier(canvas, side, gain, overlay, [px, py]) {
  const context = canvas.getContext('2d');
  const cell = canvas.width / magnified;
  const first = -(magnified - 1) / 2;
  context.clearRect(0, 0, canvas.width, canvas.height);
  for (let row = 0; row < magnified; ++row) {
    for (let column = 0; column < magnified; ++column) {
      const x = px + first + column;
      const y = py + first + row;
      if (x < 0 || y < 0 || x >= side.width || y >= side.height) continue;
      const i = y * side.width + x;
      const faulty = overlay && faultyPixel(side.mean, i);
      const bytes = [0, 1, 2].map((c) => srgbByte(gain * side.mean[3 * i + c]));
      context.fillStyle = faulty ? faultColor : `rgb(${bytes})`;
      context.fillRect(column * cell, row * cell, cell, cell);
    }
  }
  frame(context, -first * cell, -first * cell, cell, cell, 1.5);
}

// The legend of a heat map: its colours from left to right.
function drawScale(canvas, stops) {
  const context = canvas.getContext('2d');
  for (let x = 0; x < canvas.width; ++x) {
    context.fillStyle = `rgb(${colorAt(stops, x / (canvas.width - 1))})`;
    context.fillRect(x, 0, 1, 1);
  }
}

'use strict';
// Numbers of images: no element of the page is touched here.

// "NaN" and "Infinity" come as strings, because JSON has no such numbers.
const number = (value) => Number(value);

// little-endian float32 RGB in base64; null where the plane is empty
function decodePlane(base64) {
  if (!base64) return null;
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Float32Array.from({ length: bytes.length / 4 }, (_, i) => view.getFloat32(4 * i, true));
}

function decodeCase(data) {
  const pixels = data.pixels;
  const sameSize = data.width === data.golden_width && data.height === data.golden_height;
  return {
    ...data,
    sameSize,
    new: { width: data.width, height: data.height, mean: decodePlane(pixels.new), variance: decodePlane(pixels.new_variance) },
    golden: { width: data.golden_width, height: data.golden_height, mean: decodePlane(pixels.golden), variance: decodePlane(pixels.golden_variance) },
    z: sameSize ? decodePlane(pixels.z) : null, // by the gates' own rule: pages show statistics and compute none
  };
}

// The shortest decimal that reads as this float32.
function shortest(value) {
  if (!Number.isFinite(value)) return String(value).replace('Infinity', '∞');
  for (let digits = 1; digits < 9; ++digits) {
    const text = value.toPrecision(digits);
    if (Math.fround(Number(text)) === value) return String(Number(text));
  }
  return String(Number(value.toPrecision(9)));
}

// For computed values: four digits say enough.
function short(value) {
  if (!Number.isFinite(value)) return String(value).replace('Infinity', '∞');
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(2).replace('e+', 'e');
  return String(Number(value.toPrecision(4)));
}

const words = new DataView(new ArrayBuffer(4));
function ordered(value) { // float32 as an integer that grows with it
  words.setFloat32(0, value);
  const bits = words.getInt32(0);
  return bits < 0 ? -(bits & 0x7fffffff) : bits;
}

// The distance of float32 values in units in the last place; NaN if one is NaN.
function ulpsApart(a, b) {
  return Number.isNaN(a) || Number.isNaN(b) ? NaN : Math.abs(ordered(a) - ordered(b));
}

const isFaulty = (value) => !Number.isFinite(value) || value < 0;
const faultyPixel = (mean, i) => isFaulty(mean[3 * i]) || isFaulty(mean[3 * i + 1]) || isFaulty(mean[3 * i + 2]);

// The channel of a pixel that stands out most; NaN stands out above all.
function largest(of) {
  let most = 0;
  for (let c = 0; c < 3; ++c) {
    const value = of(c);
    if (Number.isNaN(value)) return value;
    if (Math.abs(value) > Math.abs(most)) most = value;
  }
  return most;
}
const pixelUlps = (one, i) => largest((c) => ulpsApart(one.new.mean[3 * i + c], one.golden.mean[3 * i + c]));
const pixelZ = (one, i) => largest((c) => one.z[3 * i + c]);

// Linear radiance as an sRGB byte; NaN is black, and the overlay marks it.
function srgbByte(linear) {
  if (!(linear > 0)) return 0;
  if (linear >= 1) return 255;
  return Math.round(255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055));
}

// Piecewise linear colours; stops are [position in 0..1, red, green, blue].
function colorAt(stops, position) {
  const at = Math.min(1, Math.max(0, position));
  let k = 1;
  while (k < stops.length - 1 && at > stops[k][0]) ++k;
  const [p0, ...from] = stops[k - 1];
  const [p1, ...to] = stops[k];
  const share = (at - p0) / (p1 - p0);
  return from.map((channel, c) => Math.round(channel + share * (to[c] - channel)));
}
const ulpsStops = [[0, 16, 18, 22], [0.3, 32, 66, 104], [0.6, 74, 140, 150], [0.85, 204, 196, 134], [1, 255, 246, 214]];
const zStops = [[0, 150, 214, 255], [0.25, 30, 72, 116], [0.5, 16, 18, 22], [0.75, 116, 74, 22], [1, 255, 212, 130]];
const maxLog2Ulps = 32;
const maxZ = 6;
const ulpsColor = (ulps) => colorAt(ulpsStops, Math.log2(1 + ulps) / maxLog2Ulps);
const zColor = (z) => colorAt(zStops, (z + maxZ) / (2 * maxZ));

// Red, green and blue bytes of pixel i in a view.
function viewColor(one, view, i, gain) {
  const shown = (mean) => [0, 1, 2].map((c) => srgbByte(gain * mean[3 * i + c]));
  const black = [0, 0, 0];
  switch (view) {
    case 'golden': return shown(one.golden.mean);
    case 'difference': return [0, 1, 2].map((c) => srgbByte(gain * Math.abs(one.new.mean[3 * i + c] - one.golden.mean[3 * i + c])));
    case 'ulps': { const ulps = pixelUlps(one, i); return Number.isNaN(ulps) ? black : ulpsColor(ulps); }
    case 'z': { const z = pixelZ(one, i); return Number.isNaN(z) ? black : zColor(z); }
    default: return shown(one.new.mean);
  }
}

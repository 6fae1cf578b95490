'use strict';
// The camera of a view: what it looks at, and how gestures move it. No element of the page is touched here.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const size = (a) => Math.hypot(...a);
const unit = (a) => times(a, 1 / (size(a) || 1));
const degrees = Math.PI / 180;

// v turned around a unit axis (Rodrigues)
function turned(v, axis, angle) {
  const c = Math.cos(angle);
  const s = Math.sin(angle);
  return add(add(times(v, c), times(cross(axis, v), s)), times(axis, dot(axis, v) * (1 - c)));
}

class OrbitCamera {
  constructor(position, target, up, fov) {
    Object.assign(this, { position, target, up, fov });
  }

  // From a camera as frames name it. It turns around the point at this distance.
  static from(camera, distance) {
    // Scenes are y up; a camera that is rolled keeps its own.
    const level = Math.abs(camera.right[1]) < 1e-3 && camera.up[1] > 0;
    return new OrbitCamera(camera.position, add(camera.position, times(camera.forward, distance)),
      level ? [0, 1, 0] : camera.up, 2 * Math.atan(camera.tan_half_fov) / degrees);
  }

  copy() { return new OrbitCamera([...this.position], [...this.target], [...this.up], this.fov); }

  get distance() { return size(sub(this.target, this.position)); }
  get forward() { return unit(sub(this.target, this.position)); }
  get right() { return unit(cross(this.forward, this.up)); }
  get above() { return cross(this.right, this.forward); }

  // Radians; never over the poles.
  orbit(yaw, pitch) {
    const away = sub(this.position, this.target);
    const now = Math.asin(Math.max(-1, Math.min(1, dot(unit(away), this.up))));
    const limit = 89 * degrees;
    const wanted = Math.max(-limit, Math.min(limit, now + pitch));
    const pitched = turned(away, this.right, now - wanted);
    this.position = add(this.target, turned(pitched, this.up, yaw));
  }

  // Shares of the picture's height.
  pan(x, y) {
    const height = 2 * this.distance * Math.tan(this.fov * degrees / 2);
    const by = add(times(this.right, -x * height), times(this.above, y * height));
    this.position = add(this.position, by);
    this.target = add(this.target, by);
  }

  dolly(factor) {
    this.position = add(this.target, times(sub(this.position, this.target), factor));
  }

  // Metres to the right, up and forward.
  fly(right, up, forward) {
    const by = add(add(times(this.right, right), times(this.above, up)), times(this.forward, forward));
    this.position = add(this.position, by);
    this.target = add(this.target, by);
  }

  // Looks at a point from where it is.
  turnTo(point) {
    if (size(sub(point, this.position)) > 0) this.target = point;
  }

  setFov(fov) { this.fov = Math.max(1, Math.min(160, fov)); }

  message(moving) {
    return { type: 'camera', position: this.position, target: this.target, up: this.up, fov: this.fov, moving };
  }
}

// Where a point is seen, in shares of width and height; null behind the camera. `aspect`: width by height.
function projected(point, camera, aspect) {
  const to = sub(point, camera.position);
  const depth = dot(to, camera.forward);
  if (!(depth > 1e-9 * size(to))) return null;
  return [0.5 + dot(to, camera.right) / (depth * camera.tan_half_fov * aspect) / 2,
    0.5 - dot(to, camera.up) / (depth * camera.tan_half_fov) / 2];
}

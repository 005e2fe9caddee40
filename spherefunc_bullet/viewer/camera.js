// An orbiting camera. Metres, z up; matrices are column by column, as WebGL takes them.

const HALF_VIEW = Math.tan((14 * Math.PI) / 180); // of the vertical field of view: narrow, so that sizes compare

function newCamera(low, high) {
  const target = low.map((each, i) => (each + high[i]) / 2);
  // Fronts face -y, so this looks from the front left, as the pictures of the documents do.
  return { azimuth: (-120 * Math.PI) / 180, elevation: (27 * Math.PI) / 180, zoom: 1, target, low, high };
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const along = (start, direction, distance) => start.map((each, i) => each + direction[i] * distance);

// Unit vectors to the right, up, and from the target to the eye.
function axes(azimuth, elevation) {
  const [c, s] = [Math.cos(elevation), Math.sin(elevation)];
  const toward = [c * Math.cos(azimuth), c * Math.sin(azimuth), s];
  const right = [-Math.sin(azimuth), Math.cos(azimuth), 0];
  return { right, up: cross(toward, right), toward };
}

// How far away the eye sees the whole box, turned as it is at first: turning must not change the size.
function fittingDistance(camera, aspect) {
  const first = newCamera(camera.low, camera.high);
  const { right, up, toward } = axes(first.azimuth, first.elevation);
  const middle = first.target;
  let farthest = 0;
  for (let k = 0; k < 8; k++) {
    const corner = middle.map((each, i) => (k & (1 << i) ? camera.high[i] : camera.low[i]) - each);
    const aside = Math.abs(dot(corner, right)) / (HALF_VIEW * aspect);
    farthest = Math.max(farthest, Math.max(aside, Math.abs(dot(corner, up)) / HALF_VIEW) + dot(corner, toward));
  }
  return farthest * 1.08;
}

function look(camera, aspect) {
  const { right, up, toward } = axes(camera.azimuth, camera.elevation);
  const distance = fittingDistance(camera, aspect) / camera.zoom;
  const eye = along(camera.target, toward, distance);
  const size = Math.hypot(...camera.high.map((each, i) => each - camera.low[i]));
  const near = Math.max(distance - 3 * size, distance / 200);
  const far = distance + 4 * size;
  const view = [0, 1, 2].flatMap((i) => [right[i], up[i], toward[i], 0]);
  view.push(-dot(right, eye), -dot(up, eye), -dot(toward, eye), 1);
  const depth = [-(far + near) / (far - near), (-2 * far * near) / (far - near)];
  const projection = [1 / (HALF_VIEW * aspect), 0, 0, 0, 0, 1 / HALF_VIEW, 0, 0, 0, 0, depth[0], -1, 0, 0, depth[1], 0];
  return { view, projection, eye, right, up, toward, distance };
}

function turn(camera, dx, dy) {
  camera.azimuth -= dx;
  camera.elevation = Math.min(1.56, Math.max(-0.5, camera.elevation + dy));
}

function zoomBy(camera, factor) {
  camera.zoom = Math.min(40, Math.max(0.3, camera.zoom * factor));
}

// Moves what is looked at by shares of the picture's height.
function shift(camera, dx, dy, aspect) {
  const { right, up, distance } = look(camera, aspect);
  const whole = 2 * HALF_VIEW * distance;
  camera.target = along(along(camera.target, right, -dx * whole), up, dy * whole);
}

// The ray through a place of the picture, which is from -1 to 1 to the right and up.
function rayThrough(camera, aspect, x, y) {
  const { eye, right, up, toward } = look(camera, aspect);
  const direction = right.map((_, i) => right[i] * x * HALF_VIEW * aspect + up[i] * y * HALF_VIEW - toward[i]);
  return { eye, direction };
}

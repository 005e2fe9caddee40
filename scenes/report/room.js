// Sets up pictures of rooms: points in their colours, a box around each object that has a function, and places.

const THICK = 0.004; // of the room's width: a box's edge
const EDGES = [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
const redrawAll = () => rooms.forEach((item) => item.redraw());
const rooms = [];

// Points as squares of a size in metres, without light: a scan brings its own. Those beyond an upright plane are hidden.
SHADERS.specks = [
  `uniform mat4 view, projection; uniform float radius; uniform vec3 plane;
  in vec2 corner; in vec3 center; in vec3 colour;
  out vec3 tint;
  void main() {
    vec4 middle = view * vec4(center, 1.0);
    tint = colour;
    bool hidden = dot(plane.xy, center.xy) > plane.z;
    gl_Position = hidden ? vec4(0.0, 0.0, 2.0, 1.0) : projection * (middle + vec4(corner * radius, 0.0, 0.0));
  }`,
  "in vec3 tint; out vec4 pixel; void main() { pixel = vec4(tint, 1.0); }",
];
SHADERS.edges = [
  `uniform mat4 view, projection; in vec3 position;
  void main() { gl_Position = projection * view * vec4(position, 1.0); }`,
  "uniform vec3 tint; out vec4 pixel; void main() { pixel = vec4(tint, 1.0); }",
];

function unpackedBytes(text, Kind) {
  return new Kind(Uint8Array.from(atob(text), (each) => each.charCodeAt(0)).buffer);
}

function roomPoints({ start, step, positions }) {
  return Float32Array.from(unpackedBytes(positions, Uint16Array), (each, i) => start[i % 3] + each * step);
}

// Triangles of a square bar from a to b.
function bar(a, b, half) {
  const away = [0, 1, 2].map((i) => b[i] - a[i]);
  const helper = Math.abs(away[2]) > 0.9 * Math.hypot(...away) ? [1, 0, 0] : [0, 0, 1];
  const unit = (v) => v.map((each) => each / (Math.hypot(...v) || 1));
  const u = unit(cross(away, helper));
  const v = unit(cross(away, u));
  const ring = (at) => [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([s, t]) => at.map((each, i) => each + half * (s * u[i] + t * v[i])));
  const [first, last] = [ring(a), ring(b)];
  const corners = [];
  for (let k = 0; k < 4; k++) {
    const next = (k + 1) % 4;
    corners.push(first[k], first[next], last[next], first[k], last[next], last[k]);
  }
  return corners.flat();
}

function boxVertices(boxes, half) {
  return boxes.flatMap(({ corners }) => EDGES.flatMap(([a, b]) => bar(corners[a], corners[b], half)));
}

function roomParts(item) {
  if (item.parts && item.parts.generation === artist.generation) return item.parts;
  const half = (THICK / 2) * Math.max(...item.high.map((each, i) => each - item.low[i]));
  const colours = Float32Array.from(unpackedBytes(item.colours, Uint8Array), (each) => each / 255);
  const specks = (...range) => {
    const [center, colour] = [item.places, colours].map((each) => [each.subarray(...range), 3, true]);
    return { drawable: uploaded("specks", { corner: [SQUARE, 2], center, colour }), count: center[0].length / 3 };
  };
  const others = item.places.length - 3 * item.walls;
  item.parts = { generation: artist.generation, specks: specks(0, others), walls: specks(others), functions: [] };
  item.parts.uses = item.uses.map(({ name, tint, middles }) => {
    const colours = Float32Array.from({ length: middles.length }, (_, i) => tint[i % 3]);
    return { name, count: middles.length / 3, drawable: ballsOf(middles, colours) };
  });
  for (const [name, tint] of Object.entries(item.functions)) {
    const vertices = boxVertices(item.boxes.filter((each) => each.function === name), half);
    item.parts.functions.push({ name, tint, count: vertices.length / 3, drawable: uploaded("edges", { position: [vertices, 3] }) });
  }
  return item.parts;
}

function drawBars(part, settings) {
  use(part.drawable, { ...settings, tint: part.tint });
  if (part.count) artist.gl.drawArrays(artist.gl.TRIANGLES, 0, part.count);
}

// How far above its box's top, in lines, each name stands so that none lies over another; the nearest stay at theirs.
function freePlaces(tops, line, height) {
  const taken = [];
  const shifts = [0];
  for (let n = 1; n <= tops.length; n++) shifts.push(n, -n);
  for (const top of tops) {
    const meets = (y) => taken.some((other) => Math.abs(other.y - y) < line && Math.abs(other.x - top.x) < other.half + top.half);
    const free = shifts.map((n) => top.y - n * line).filter((y) => !meets(y));
    const y = free.find((each) => each > line && each < height) ?? free[0];
    taken.push({ ...top, y });
  }
  return taken;
}

// The names of the boxes, at their tops or above, with a line to the box that a name stands off.
function drawNames(item, paper, { view, projection }, width, height, scale) {
  const placed = (point) => {
    const times = (m, v) => [0, 1, 2, 3].map((r) => v.reduce((sum, each, c) => sum + m[4 * c + r] * each, 0));
    const [x, y, , w] = times(projection, times(view, [...point, 1]));
    return { x: ((x / w + 1) * width) / 2, y: ((1 - y / w) * height) / 2, w };
  };
  paper.font = `600 ${13 * scale}px system-ui, sans-serif`;
  paper.textAlign = "center";
  const shown = item.boxes.filter((each) => item.state[each.function]);
  const tops = shown.map((each) => {
    const middle = [0, 1, 2].map((i) => each.corners.slice(4).reduce((sum, corner) => sum + corner[i] / 4, 0));
    const text = `${each.function} ${each.score.toFixed(2)}${each.unsure ? " ?" : ""}`;
    const at = placed(middle);
    return { each, text, ...at, top: at.y, half: paper.measureText(text).width / 2 + 4 * scale };
  });
  for (const { each, text, x, y, top, half } of freePlaces(tops.sort((a, b) => a.w - b.w), 20 * scale, height)) {
    const ink = `rgb(${item.functions[each.function].map((c) => Math.round(c * 200)).join(" ")})`;
    paper.strokeStyle = ink;
    paper.lineWidth = scale;
    paper.beginPath();
    paper.moveTo(x, y);
    paper.lineTo(x, top);
    paper.stroke();
    paper.fillStyle = "rgba(255, 255, 255, 0.85)";
    paper.fillRect(x - half, y - 16 * scale, 2 * half, 19 * scale);
    paper.fillStyle = ink;
    paper.fillText(text, x, y - 2 * scale);
  }
}

function drawRoom(item) {
  const { canvas } = item;
  const scale = Math.min(Math.max(devicePixelRatio, 1.5), 3);
  const [width, height] = [canvas.clientWidth * scale, canvas.clientHeight * scale].map(Math.round);
  if (!width || !height) return;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const { view, projection, toward } = look(item.camera, width / height);
  const parts = roomParts(item);
  const settings = { view, projection };
  begin(width, height);
  const radius = item.radius * item.state.size;
  const [x, y] = toward; // walls on the side of the eye would hide the room
  const front = [x, y, x * item.middle[0] + y * item.middle[1]];
  drawBalls(parts.specks.drawable, { ...settings, radius, plane: [0, 0, 1] }, parts.specks.count);
  drawBalls(parts.walls.drawable, { ...settings, radius, plane: front }, parts.walls.count);
  for (const part of parts.functions) if (item.state[part.name]) drawBars(part, settings);
  for (const { name, count, drawable } of parts.uses)
    if (item.state[name]) drawBalls(drawable, { ...settings, radius: item.bead, opacity: 1 }, count);
  finish(canvas);
  if (item.state.names) drawNames(item, canvas.getContext("2d"), settings, width, height, scale);
}

// What can be switched off, with its colour: the boxes of each function, and the places of each use.
function keys(item) {
  return [...Object.entries(item.functions).map(([name, tint]) => ({ name, tint })), ...item.uses];
}

function roomBar(item, changed, reset) {
  const line = element("div", { className: "display-bar" });
  for (const { name, tint } of keys(item)) {
    const label = tick(name, item.state, name, changed);
    const key = element("i", { className: "swatch" });
    key.style.background = `rgb(${tint.map((each) => Math.round(each * 255)).join(" ")})`;
    label.append(key);
    line.append(label);
  }
  line.append(tick("names", item.state, "names", changed));
  line.append(slider("size of points", item.state, "size", changed));
  const button = element("button", { type: "button" }, "reset view");
  button.addEventListener("click", reset);
  line.append(button);
  return line;
}

function setUpRoom(holder) {
  const item = JSON.parse(holder.querySelector("script").textContent);
  item.places = roomPoints(item.points);
  for (const each of item.uses) each.middles = roomPoints(each.middles);
  item.camera = newCamera(item.low, item.high);
  item.state = { names: true, size: 0.5 };
  for (const { name } of keys(item)) item.state[name] = true;
  let waiting = false;
  item.redraw = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; drawRoom(item); });
  };
  const reset = () => {
    Object.assign(item.camera, newCamera(item.low, item.high), { azimuth: item.azimuth, elevation: 0.56 });
    item.redraw();
  };
  item.canvas = element("canvas", { className: "room", tabIndex: 0, role: "img", ariaLabel: item.name });
  holder.append(roomBar(item, item.redraw, reset), element("div", { className: "display-picture" }, item.canvas));
  listen(item.canvas, item.camera, item.redraw, () => {});
  item.canvas.addEventListener("dblclick", reset);
  new ResizeObserver(item.redraw).observe(item.canvas);
  rooms.push(item);
  reset();
}

function start() {
  const holders = [...document.querySelectorAll(".room-display")];
  if (prepare()) holders.forEach(setUpRoom);
  else {
    const text = "This browser draws no 3D here: WebGL 2 is off or missing.";
    holders.forEach((each) => each.append(element("p", {}, text)));
  }
}

start();

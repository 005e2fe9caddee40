// Displays: one object in panels side by side, drawn when they are seen and when something changes.

const displays = [];
const BIN_COLOURS = ["#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7"]; // Okabe and Ito

function unpacked(text, Kind) {
  const bytes = Uint8Array.from(atob(text), (each) => each.charCodeAt(0));
  return new Kind(bytes.buffer);
}

function positions({ start, step, positions: text }) {
  return Float32Array.from(unpacked(text, Uint16Array), (each, i) => start[i % 3] + each * step);
}

const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255);
const themed = (name) => rgb(getComputedStyle(document.documentElement).getPropertyValue(`--display-${name}`).trim());

function decoded(data) {
  const item = { ...data, object: { ...data.object, points: positions(data.object) } };
  const { faces, wide } = data.object;
  if (faces) item.object.triangles = unpacked(faces, wide ? Uint32Array : Uint16Array);
  item.spheres = data.spheres.map((each) => ({ radius: each.radius, centers: positions(each) }));
  for (const layer of item.panels.flatMap((panel) => panel.layers)) {
    const { cubes } = layer;
    for (const key of ["corners", "counts", "members", "others", "speaks_for"])
      if (key in cubes) cubes[key] = unpacked(cubes[key], Float32Array);
  }
  const radii = item.panels.flatMap((panel) => panel.layers.map((layer) => layer.radius));
  item.radii = [...new Set(radii)].sort((a, b) => a - b);
  return item;
}

const most = (values) => values.reduce((a, b) => Math.max(a, Math.abs(b)), 0);
const layersOf = (item, radius) =>
  item.panels.flatMap((panel) => panel.layers.filter((each) => each.radius === radius));

// Lowest and highest centre over all panels, at least so many radii apart that a flat layer is no rainbow.
function heightRange(item, radius) {
  let [low, high] = [Infinity, -Infinity];
  for (const layer of layersOf(item, radius)) {
    const { centers } = item.spheres[layer.spheres];
    for (let i = 2; i < centers.length; i += 3) [low, high] = [Math.min(low, centers[i]), Math.max(high, centers[i])];
  }
  return low > high ? [0, item.flat * radius] : [low, Math.max(high, low + item.flat * radius)];
}

function ramp(colours, share) {
  const at = Math.min(Math.max(share, 0), 1) * (colours.length - 1);
  const k = Math.min(Math.floor(at), colours.length - 2);
  return [0, 1, 2].map((i) => colours[k][i] + (at - k) * (colours[k + 1][i] - colours[k][i]));
}

function sphereColours(item, layer, colour) {
  const { centers } = item.spheres[layer.spheres];
  const { corners, side } = layer.cubes;
  const [low, high] = heightRange(item, layer.radius);
  const bins = BIN_COLOURS.map(rgb);
  const colours = new Float32Array(centers.length);
  for (let i = 0; i < centers.length; i += 3) {
    if (colour === "height") colours.set(ramp(item.height_colours, (centers[i + 2] - low) / (high - low)), i);
    else {
      const [x, y, z] = [0, 1, 2].map((k) => Math.floor((centers[i + k] - (corners[k] || 0)) / side));
      colours.set(bins[(((x + 3 * y + 5 * z) % 7) + 7) % 7], i); // no two neighbours along an axis alike
    }
  }
  return colours;
}

// Colour and opacity of each cube: by its count, or by what it speaks for.
function cubeColours(item, layer) {
  const { counts, speaks_for: evidence } = layer.cubes;
  const [cube, pro, contra, neutral] = ["cube", "for", "against", "neutral"].map(themed);
  const alike = layersOf(item, layer.radius);
  const greatest = evidence ? most(evidence) : Math.max(...alike.map((each) => most(each.cubes.counts)));
  return Array.from(counts, (count, i) => {
    if (!evidence) return [...cube, 0.03 + (0.27 * count) / greatest];
    const share = greatest ? Math.sqrt(Math.abs(evidence[i]) / greatest) : 0;
    const tint = share < 0.02 ? neutral : evidence[i] > 0 ? pro : contra;
    return [...tint, count > 0 ? 0.05 + 0.4 * share : -share]; // below 0: outline only
  });
}

// What is on the graphics card of a layer, coloured as it has to be now.
function parts(item, layer, colour) {
  const { centers, radius } = item.spheres[layer.spheres];
  if (!layer.parts || layer.parts.generation !== artist.generation) {
    const blank = new Float32Array(centers.length);
    const cubes = cubesOf(layer.cubes.corners, new Float32Array(4 * layer.cubes.counts.length));
    const spheres = ballsOf(centers, blank);
    layer.parts = { generation: artist.generation, radius, count: centers.length / 3, spheres, cubes };
  }
  const wanted = `${colour} ${item.theme}`;
  if (layer.parts.wanted !== wanted) {
    refill(layer.parts.spheres, "colour", sphereColours(item, layer, colour));
    Object.assign(layer.parts, { wanted, colours: cubeColours(item, layer) });
  }
  return layer.parts;
}

function objectParts(item) {
  if (item.parts && item.parts.generation === artist.generation) return item.parts;
  const { points, triangles, radius } = item.object;
  item.parts = { generation: artist.generation, ground: groundOf(), count: points.length / 3, radius };
  item.parts.mesh = triangles ? meshOf(points, triangles) : ballsOf(points, new Float32Array(points.length));
  return item.parts;
}

// Translucent drawables must be drawn from the farthest to the nearest.
function sortedCubes(layer, drawable, colours, toward) {
  const { corners } = layer.cubes;
  const near = colours.map((_, i) => dot(corners.subarray(3 * i, 3 * i + 3), toward));
  const order = colours.map((_, i) => i).sort((a, b) => near[a] - near[b]);
  refill(drawable, "low", Float32Array.from(order.flatMap((i) => [...corners.subarray(3 * i, 3 * i + 3)])));
  refill(drawable, "colour", Float32Array.from(order.flatMap((i) => colours[i])));
}

function groundSquare(item) {
  const width = Math.max(...item.high.map((each, i) => each - item.low[i]));
  const power = 10 ** Math.floor(Math.log10(width / 4));
  return [5, 2, 1].map((each) => each * power).find((each) => each <= width / 4);
}

function drawObject(item, settings) {
  const { mesh, count, radius } = objectParts(item);
  const opacity = item.state.opacity;
  const tint = themed("object");
  if (!item.object.triangles && item.parts.tint !== String(tint)) {
    refill(mesh, "colour", Float32Array.from({ length: 3 * count }, (_, i) => tint[i % 3]));
    item.parts.tint = String(tint);
  }
  const draw = () => (item.object.triangles
    ? drawMesh(mesh, { ...settings, tint, opacity })
    : drawBalls(mesh, { ...settings, radius, opacity }, count));
  if (opacity > 0.01) drawFront(draw);
}

function drawPanel(item, panel) {
  const { canvas, layer } = panel;
  const scale = artist.slow ? 1 : Math.min(Math.max(devicePixelRatio, 2), 3); // twice as fine, for smooth outlines
  const [width, height] = [canvas.clientWidth * scale, canvas.clientHeight * scale].map(Math.round);
  if (!layer || !width || !height) return;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const { view, projection, toward } = look(item.camera, width / height);
  const shown = parts(item, layer, item.state.colour);
  const settings = { view, projection };
  begin(width, height);
  const reach = 1.1 * Math.hypot(...item.high.map((each, i) => each - item.low[i]));
  const middle = item.low.map((each, i) => (each + item.high[i]) / 2);
  const square = groundSquare(item);
  drawGround(objectParts(item).ground, { ...settings, middle, reach, square, tint: themed("ground") });
  if (item.state.spheres) drawBalls(shown.spheres, { ...settings, radius: shown.radius, opacity: 1 }, shown.count);
  const solid = item.state.opacity > 0.99;
  if (solid) drawObject(item, settings);
  if (item.state.cubes) {
    sortedCubes(layer, shown.cubes, shown.colours, toward);
    drawCubes(shown.cubes, { ...settings, side: layer.cubes.side, edge: scale * 0.6 }, shown.colours.length);
  }
  if (!solid) drawObject(item, settings);
  finish(canvas);
}

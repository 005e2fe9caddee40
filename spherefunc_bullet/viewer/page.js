// Sets the displays of a page up.

const redrawAll = () => displays.forEach((item) => item.redraw());

// The first cube that a ray enters, by slabs.
function cubeUnder({ eye, direction }, { corners, side }) {
  let [found, nearest] = [-1, Infinity];
  for (let i = 0; i < corners.length / 3; i++) {
    let [enter, leave] = [0, Infinity];
    for (let k = 0; k < 3; k++) {
      const [a, b] = [0, side].map((add) => (corners[3 * i + k] + add - eye[k]) / direction[k]);
      [enter, leave] = [Math.max(enter, Math.min(a, b)), Math.min(leave, Math.max(a, b))];
    }
    if (enter < leave && enter < nearest) [found, nearest] = [i, enter];
  }
  return found;
}

function cubeText({ counts, members, others, speaks_for: evidence }, i) {
  const here = `${+counts[i].toFixed(1)} ${counts[i] === 1 ? "sphere" : "spheres"} here`;
  if (!evidence) return here;
  const side = evidence[i] > 0 ? "speaks for" : evidence[i] < 0 ? "speaks against" : "speaks neither way";
  return `${here}; nearest with the function ${members[i].toFixed(1)}, without ${others[i].toFixed(1)}: ${side}`;
}

function hover(item, panel, event) {
  const { canvas, tip, layer } = panel;
  tip.hidden = true;
  if (!event || !layer || !item.state.cubes) return;
  const box = canvas.getBoundingClientRect();
  const [x, y] = [event.clientX - box.left, event.clientY - box.top];
  const ray = rayThrough(item.camera, box.width / box.height, (2 * x) / box.width - 1, 1 - (2 * y) / box.height);
  const found = cubeUnder(ray, layer.cubes);
  if (found < 0) return;
  tip.hidden = false;
  tip.textContent = cubeText(layer.cubes, found);
  tip.style.left = `${Math.min(x + 14, box.width - 190)}px`;
  tip.style.top = `${y + 14}px`;
}

function panelParts(item, panel) {
  panel.canvas = element("canvas", { tabIndex: 0, role: "img", ariaLabel: `${item.name}, ${panel.title}` });
  panel.tip = element("div", { className: "display-tip", hidden: true });
  panel.note = element("p", { className: "display-note" });
  panel.details = element("div", { className: "display-details" });
  const picture = element("div", { className: "display-picture" }, panel.canvas, panel.tip);
  return element("figure", {}, element("h3", {}, panel.title), picture, panel.note, panel.details);
}

// Shows the layer of the radius chosen, or says that there is none.
function showLayer(item, panel) {
  const layer = panel.layers.find((each) => each.radius === item.state.radius);
  if (layer && layer === panel.layer) return;
  panel.layer = layer;
  panel.canvas.parentElement.classList.toggle("missing", !layer);
  panel.note.textContent = layer ? layer.note : `Spheres of ${radiusText(item.state.radius)} do not count here.`;
  panel.details.innerHTML = layer ? layer.details : "";
}

// Whether spheres of a display were counted in cubes; outlines of places are not.
function counted(item) {
  return item.panels.some(({ layers }) => layers.some((each) => each.cubes.corners.length));
}

function legend(item) {
  const { state } = item;
  const words = (text) => element("span", { className: "display-key" }, text);
  const keys = [words(`squares on the ground: ${centimetres(groundSquare(item))}`)];
  const layers = layersOf(item, state.radius);
  const heights = () => heightLegend(item.height_colours, heightRange(item, state.radius));
  if (!counted(item)) return keys;
  if (state.spheres) keys.push(state.colour === "height" ? heights() : words("spheres of one cube have one colour"));
  if (state.cubes && item.explains) keys.push(...evidenceLegend());
  const sides = [...new Set(layers.map((each) => each.cubes.side))];
  const greatest = Math.max(...layers.map((each) => most(each.cubes.counts)));
  if (state.cubes && !item.explains) keys.push(countLegend(sides, greatest));
  return keys;
}

function setUp(holder) {
  const item = decoded(JSON.parse(holder.querySelector("script").textContent));
  item.camera = newCamera(item.low, item.high);
  item.state = {
    radius: item.radius, spheres: !item.explains, cubes: item.explains, colour: "height",
    opacity: item.explains ? 0.25 : 0.4,
  };
  item.holder = holder;
  displays.push(item);
  let waiting = false;
  item.redraw = () => {
    if (waiting || !item.seen) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; item.panels.forEach((panel) => drawPanel(item, panel)); });
  };
  build(item);
  holder.querySelector(".display-still")?.remove();
}

function build(item) {
  const keys = element("div", { className: "display-legend" });
  const refresh = () => {
    item.panels.forEach((panel) => showLayer(item, panel));
    keys.replaceChildren(...legend(item));
    item.redraw();
  };
  const reset = () => { Object.assign(item.camera, newCamera(item.low, item.high)); item.redraw(); };
  const panels = element("div", { className: "display-panels" }, ...item.panels.map((panel) => panelParts(item, panel)));
  item.holder.append(controlBar(item.state, item.radii, counted(item), refresh, reset), keys, panels);
  for (const panel of item.panels) {
    listen(panel.canvas, item.camera, item.redraw, (event) => hover(item, panel, event));
    panel.canvas.addEventListener("dblclick", reset);
  }
  refresh();
  new ResizeObserver(item.redraw).observe(panels);
  const scrolled = (entries) => { item.seen = entries.at(-1).isIntersecting; item.redraw(); };
  new IntersectionObserver(scrolled, { rootMargin: "300px" }).observe(item.holder);
}

function start() {
  const holders = [...document.querySelectorAll(".display")];
  if (prepare()) holders.forEach(setUp);
  else {
    const text = "This browser draws no 3D here: WebGL 2 is off or missing. The picture stands still.";
    holders.forEach((each) => each.append(element("p", {}, text)));
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => {
    displays.forEach((item) => { item.theme = event.matches; });
    redrawAll();
  });
}

// The page with its stills and tables is shown first: it is what is read, and all that there is without WebGL.
addEventListener("load", () => setTimeout(start, 30));

// What surrounds the pictures: switches, legends, and how mouse, fingers and keys turn them.

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

const centimetres = (metres) => {
  const cm = metres * 100;
  return metres < 0.01 ? `${+(metres * 1000).toPrecision(2)} mm` : `${cm < 10 ? +cm.toFixed(1) : Math.round(cm)} cm`;
};
const radiusText = (metres) =>
  metres < 0.01 ? `${+(metres * 1000).toPrecision(4)} mm` : `${+(metres * 100).toPrecision(4)} cm`;

function tick(text, state, key, changed) {
  const box = element("input", { type: "checkbox", checked: state[key] });
  box.addEventListener("change", () => { state[key] = box.checked; changed(); });
  return element("label", {}, box, ` ${text}`);
}

function choice(text, options, state, key, changed) {
  const list = element("select", {}, ...options.map(([value, words]) => element("option", { value }, words)));
  list.value = state[key];
  list.addEventListener("change", () => {
    state[key] = isNaN(list.value) ? list.value : Number(list.value);
    changed();
  });
  return element("label", {}, `${text} `, list);
}

function slider(text, state, key, changed) {
  const range = element("input", { type: "range", min: 0, max: 1, step: 0.01, value: state[key] });
  range.addEventListener("input", () => { state[key] = Number(range.value); changed(); });
  return element("label", {}, `${text} `, range);
}

// Switches for all panels of a display; those for spheres only where spheres were counted in cubes.
function controlBar(state, radii, counted, changed, reset) {
  const bar = element("div", { className: "display-bar" });
  if (radii.length > 1) {
    const options = radii.map((each) => [each, radiusText(each)]);
    bar.append(choice("radius of spheres", options, state, "radius", changed));
  }
  if (counted) {
    bar.append(tick("spheres", state, "spheres", changed));
    bar.append(choice("coloured by", [["height", "height"], ["cube", "cube"]], state, "colour", changed));
    bar.append(tick("cubes", state, "cubes", changed));
  }
  bar.append(slider("object", state, "opacity", changed));
  const button = element("button", { type: "button" }, "reset view");
  button.addEventListener("click", reset);
  bar.append(button);
  return bar;
}

function swatch(className, text) {
  return element("span", { className: "display-key" }, element("i", { className: `swatch ${className}` }), ` ${text}`);
}

function heightLegend(colours, [low, high]) {
  const stops = colours.map((rgb) => `rgb(${rgb.map((each) => Math.round(each * 255)).join(" ")})`);
  const bar = element("i", { className: "swatch ramp" });
  bar.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
  const words = ["spheres by height above ground: ", centimetres(low), " ", bar, " ", centimetres(high)];
  return element("span", { className: "display-key" }, ...words);
}

function countLegend(sides, most) {
  const text = sides.map(centimetres).join(", ");
  const ramp = [" 1 ", element("i", { className: "swatch ramp counts" }), ` ${most}`];
  return element("span", { className: "display-key" }, `cubes of ${text}, by spheres in each:`, ...ramp);
}

function evidenceLegend() {
  return [
    swatch("for", "cube speaks for: its count is nearer to that of the nearest training objects with the function"),
    swatch("against", "speaks against: nearer to that of the nearest without"),
    swatch("empty", "outline only: no sphere here, but in a neighbour"),
  ];
}

// Turns by dragging, moves by dragging with the right button, Shift or two fingers, zooms by wheel or pinch.
function listen(canvas, camera, changed, hovered) {
  const fingers = new Map();
  const aspect = () => canvas.clientWidth / canvas.clientHeight;
  canvas.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    canvas.setPointerCapture(event.pointerId);
  });
  for (const end of ["pointerup", "pointercancel"])
    canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return hovered(event);
    const before = [...fingers.values()];
    const [x, y] = fingers.get(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    const [dx, dy] = [event.clientX - x, event.clientY - y];
    const share = 1 / canvas.clientHeight;
    if (fingers.size === 2) {
      pinch(camera, before, [...fingers.values()]);
      shift(camera, (dx * share) / 2, (dy * share) / 2, aspect());
    } else if (event.shiftKey || event.buttons & 2) shift(camera, dx * share, dy * share, aspect());
    else turn(camera, dx * 0.009, dy * 0.009);
    changed();
  });
  canvas.addEventListener("pointerleave", () => hovered(null));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => wheeled(event, canvas, camera, changed), { passive: false });
  canvas.addEventListener("keydown", (event) => pressed(event, camera, changed));
}

// A wheel over a picture zooms it once it has been clicked, so that a long page can be scrolled past it.
function wheeled(event, canvas, camera, changed) {
  const fits = document.documentElement.scrollHeight <= innerHeight + 1;
  if (!fits && !event.ctrlKey && document.activeElement !== canvas) return;
  event.preventDefault();
  zoomBy(camera, Math.exp(-Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY), 100) * 0.002));
  changed();
}

function pinch(camera, before, after) {
  const apart = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);
  if (apart(before) > 0) zoomBy(camera, apart(after) / apart(before));
}

function pressed(event, camera, changed) {
  const turns = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
  if (event.key in turns) turn(camera, ...turns[event.key]);
  else if (event.key === "+" || event.key === "=") zoomBy(camera, 1.15);
  else if (event.key === "-") zoomBy(camera, 1 / 1.15);
  else return;
  event.preventDefault();
  changed();
}

// Draws every panel in one hidden canvas, since browsers allow few with WebGL, and copies it to the panel's own.

const SQUARE = [-1, -1, 1, -1, -1, 1, 1, 1];
const artist = { canvas: document.createElement("canvas"), gl: null, programs: {}, generation: 0 };

// Returns whether the browser can draw.
function prepare() {
  artist.gl = artist.canvas.getContext("webgl2", { alpha: true, antialias: false, premultipliedAlpha: true });
  if (!artist.gl) return false;
  artist.slow = drawnBySoftware(artist.gl);
  artist.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  artist.canvas.addEventListener("webglcontextrestored", () => { compileAll(); redrawAll(); });
  compileAll();
  return true;
}

// Whether the processor draws, which takes a second for what a graphics card does at once.
function drawnBySoftware(gl) {
  const about = gl.getExtension("WEBGL_debug_renderer_info");
  const name = gl.getParameter(about ? about.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

function compileAll() {
  artist.generation += 1; // buffers of an earlier one are gone
  for (const [name, sources] of Object.entries(SHADERS)) artist.programs[name] = compiled(...sources);
}

function compiled(vertex, fragment) {
  const gl = artist.gl;
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, `#version 300 es\nprecision highp float;\n${source}`);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) console.error(gl.getShaderInfoLog(shader));
  }
  gl.linkProgram(program);
  return program;
}

// A drawable: attributes as {name: [values, size, per instance]}, and triangles by faces, strip or number.
function uploaded(name, attributes, faces) {
  const gl = artist.gl;
  const drawable = { program: artist.programs[name], array: gl.createVertexArray(), buffers: {}, faces };
  gl.bindVertexArray(drawable.array);
  for (const [key, [values, size, each]] of Object.entries(attributes)) {
    const place = gl.getAttribLocation(drawable.program, key);
    drawable.buffers[key] = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, drawable.buffers[key]);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(values), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
    if (each) gl.vertexAttribDivisor(place, 1);
  }
  if (faces) {
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
  }
  gl.bindVertexArray(null);
  return drawable;
}

function refill(drawable, key, values) {
  artist.gl.bindBuffer(artist.gl.ARRAY_BUFFER, drawable.buffers[key]);
  artist.gl.bufferData(artist.gl.ARRAY_BUFFER, values, artist.gl.DYNAMIC_DRAW);
}

function use(drawable, settings) {
  const gl = artist.gl;
  gl.useProgram(drawable.program);
  gl.bindVertexArray(drawable.array);
  for (const [key, value] of Object.entries(settings)) {
    const place = gl.getUniformLocation(drawable.program, key);
    if (typeof value === "number") gl.uniform1f(place, value);
    else if (value.length === 3) gl.uniform3fv(place, value);
    else gl.uniformMatrix4fv(place, false, value);
  }
}

const ballsOf = (centers, colours) =>
  uploaded("spheres", { corner: [SQUARE, 2], center: [centers, 3, true], colour: [colours, 3, true] });
const meshOf = (vertices, faces) => uploaded("mesh", { position: [vertices, 3] }, faces);
const groundOf = () => uploaded("ground", { corner: [SQUARE, 2] });

function cubesOf(corners, colours) {
  const [place, across] = [[], []];
  for (let axis = 0; axis < 3; axis++)
    for (const end of [0, 1])
      for (const [u, v] of [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]]) {
        const corner = [0, 0, 0];
        [corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]] = [end, u, v];
        place.push(...corner);
        across.push(u, v);
      }
  const each = { corner: [place, 3], across: [across, 2], low: [corners, 3, true], colour: [colours, 4, true] };
  return uploaded("cubes", each);
}

function begin(width, height) {
  const { gl, canvas } = artist;
  if (canvas.width < width) canvas.width = width;
  if (canvas.height < height) canvas.height = height;
  gl.viewport(0, 0, width, height);
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LEQUAL);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  gl.depthMask(true);
  gl.colorMask(true, true, true, true);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
}

function finish(target) {
  const { width, height } = target;
  const paper = target.getContext("2d");
  paper.clearRect(0, 0, width, height);
  paper.drawImage(artist.canvas, 0, artist.canvas.height - height, width, height, 0, 0, width, height);
}

function drawGround(drawable, settings) {
  const gl = artist.gl;
  use(drawable, settings);
  gl.depthMask(false);
  gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  gl.depthMask(true);
}

function drawBalls(drawable, settings, count) {
  use(drawable, settings);
  if (count) artist.gl.drawArraysInstanced(artist.gl.TRIANGLE_STRIP, 0, 4, count);
}

function drawMesh(drawable, settings) {
  const gl = artist.gl;
  use(drawable, settings);
  const kind = drawable.faces instanceof Uint32Array ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT;
  gl.drawElements(gl.TRIANGLES, drawable.faces.length, kind, 0);
}

// Draws twice, first the distance alone, so that of something translucent only the front is seen.
function drawFront(draw) {
  const gl = artist.gl;
  gl.colorMask(false, false, false, false);
  draw();
  gl.colorMask(true, true, true, true);
  draw();
}

function drawCubes(drawable, settings, count) {
  const gl = artist.gl;
  use(drawable, settings);
  gl.depthMask(false);
  if (count) gl.drawArraysInstanced(gl.TRIANGLES, 0, 36, count);
  gl.depthMask(true);
}

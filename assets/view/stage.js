// What is seen: camera, buffers, drawing.

/** Vertical viewing angle: 1/tan of its half, some 25 degrees in all. */
const LENS = 4.5;
/** More spans than this are drawn as lines. */
const MAX_SPANS = 200000;
/** Triangles of all tubes. */
const MAX_TRIANGLES = 2500000;
/** Half the angle of the stripe, rad, as in the pictures. */
const STRIPE_ANGLE = 0.3;
/** Colour of the obstacles' lines: seen on light and on dark, without hiding the rods. */
const OBSTACLE = [150, 156, 168];
/** Arrow of the largest force, in radii of the thickest rod. */
const ARROW = 4.5;
/** More arrows than this hide the rods: they are not shown until asked for. */
const MANY_ARROWS = 60;

/** Pixels at the top and the bottom that title and controls take. */
const ABOVE = 80, BELOW = 125;

const canvas = document.getElementById("canvas");
const gl = canvas.getContext("webgl2", { antialias: false, alpha: false });

const view = {
  turn: film.axes.map((row) => [...row]),
  target: [0, 0, 0],
  distance: 1,
  frame: film.frames.length - 1,
  quantity: 0,
  forces: film.frames.every((frame) => frame.forces.length <= MANY_ARROWS),
  stripe: true,
};

const thickest = film.frames.reduce((most, frame) => Math.max(most, ...frame.radii.flat()), 1e-300);
let largestForce = Math.max(0, ...film.frames.flatMap((frame) => frame.forces.map((f) => Math.hypot(f[3], f[4], f[5]))));

/** Makes a program and finds its inputs. */
function program(vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  const uniforms = {};
  for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); i++) {
    const name = gl.getActiveUniform(made, i).name;
    uniforms[name] = gl.getUniformLocation(made, name);
  }
  const inputs = {};
  for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_ATTRIBUTES); i++) {
    const name = gl.getActiveAttrib(made, i).name;
    inputs[name] = gl.getAttribLocation(made, name);
  }
  return { made, uniforms, inputs };
}

const stage = gl && {
  tube: program(TUBE_VERTEX, SURFACE),
  ball: program(BALL_VERTEX, SURFACE),
  line: program(LINE_VERTEX, SURFACE),
  arrow: program(ARROW_VERTEX, SURFACE),
  screen: program(SCREEN_VERTEX, SCREEN),
  nodes: gl.createBuffer(),
  forces: gl.createBuffer(),
  grid: gl.createBuffer(),
  palettes: film.quantities.map((quantity) => paletteTexture(quantity.colors)),
  span: null,
  cone: arrowMesh(),
  sphere: ballMesh(),
  shown: -1,
  size: [0, 0],
};

function paletteTexture(colors) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, colors.length, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(colors.flat()));
  setFilter(gl.LINEAR);
  return texture;
}

function setFilter(filter) {
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
}

/** A buffer of vertices and one of the triangles between the points of a grid. */
function gridMesh(rows, columns, vertex) {
  const [vertices, indices] = [[], []];
  for (let i = 0; i < rows; i++) {
    for (let j = 0; j <= columns; j++) {
      vertices.push(...vertex(i, j / columns));
      if (i + 1 < rows && j < columns) {
        const [a, b] = [i * (columns + 1) + j, (i + 1) * (columns + 1) + j];
        indices.push(a, a + 1, b, b, a + 1, b + 1);
      }
    }
  }
  const [points, triangles] = [gl.createBuffer(), gl.createBuffer()];
  gl.bindBuffer(gl.ARRAY_BUFFER, points);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.STATIC_DRAW);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, triangles);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(indices), gl.STATIC_DRAW);
  return { points, triangles, count: indices.length };
}

/** Tube of a span in as many pieces and sides as it needs and as can be afforded. */
function spanGrid(spans, turning) {
  const sides = spans < 5000 ? 28 : spans < 20000 ? 16 : spans < 60000 ? 10 : 6;
  const affordable = Math.floor(MAX_TRIANGLES / (2 * sides * Math.max(spans, 1)));
  const pieces = Math.max(1, Math.min(Math.ceil(turning / 0.12), affordable, 12));
  if (stage.span?.sides !== sides || stage.span?.pieces !== pieces) {
    const mesh = gridMesh(pieces + 1, sides, (i, x) => [i / pieces, x - 0.5]);
    stage.span = { ...mesh, sides, pieces };
  }
  return stage.span;
}

/** Shaft and head: place along, distance from the axis in radii of the shaft, slope of the normal, turn. */
function arrowMesh() {
  const rings = [[0, 0.32, 0], [0.5, 0.32, 0], [0.5, 0.32, -9], [0.5, 1, -9], [0.5, 1, 0.33], [1, 0, 0.33]];
  return gridMesh(rings.length, 16, (i, x) => [...rings[i], x]);
}

function ballMesh() {
  const ring = (i) => [Math.sin((Math.PI * i) / 12), Math.cos((Math.PI * i) / 12)];
  return gridMesh(13, 20, (i, x) => {
    const [r, z] = ring(i);
    return [r * Math.cos(2 * Math.PI * x), r * Math.sin(2 * Math.PI * x), z];
  });
}

/** Frame buffers of the canvas's size: one with several samples a pixel, one to read from. */
function resize(width, height) {
  if (stage.size[0] === width && stage.size[1] === height) return;
  for (const old of stage.attached ?? []) old.texture ? gl.deleteTexture(old.texture) : gl.deleteRenderbuffer(old.buffer);
  [canvas.width, canvas.height] = stage.size = [width, height];
  const samples = Math.min(4, gl.getParameter(gl.MAX_SAMPLES));
  const attached = [];
  const framebuffer = (attach) => {
    const made = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, made);
    attach(gl.COLOR_ATTACHMENT0, gl.RGBA8);
    attach(gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24);
    return made;
  };
  stage.many = framebuffer((place, format) => {
    const buffer = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
    gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
    attached.push({ buffer });
  });
  stage.one = framebuffer((place, format) => {
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    setFilter(gl.NEAREST);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, place, gl.TEXTURE_2D, texture, 0);
    attached.push({ texture });
  });
  stage.attached = attached;
  [stage.drawn, stage.depth] = attached.slice(2).map((a) => a.texture);
}

/** Points the camera so that all nodes of some frames are seen, from where it looks, clear of title and controls. */
function fit() {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (const index of new Set([0, film.frames.length >> 1, view.frame])) {
    const { data } = frameNodes(index);
    for (let i = 0; i < data.length; i += AS_DRAWN) {
      for (let k = 0; k < 3; k++) {
        const row = view.turn[k];
        const x = row[0] * data[i] + row[1] * data[i + 1] + row[2] * data[i + 2];
        low[k] = Math.min(low[k], x - thickest);
        high[k] = Math.max(high[k], x + thickest);
      }
    }
  }
  const any = isFinite(low[0]);
  const center = low.map((x, k) => (any ? 0.5 * (x + high[k]) : 0));
  const [width, height, depth] = low.map((x, k) => (any ? high[k] - x : 1));
  const free = Math.max(canvas.clientHeight - ABOVE - BELOW, 100);
  const perPixel = Math.max(height / free, width / (0.92 * canvas.clientWidth));
  view.distance = 0.5 * LENS * perPixel * canvas.clientHeight + 0.5 * depth;
  center[1] -= 0.5 * (BELOW - ABOVE) * perPixel;
  view.target = [0, 1, 2].map((k) => view.turn.reduce((sum, row, j) => sum + row[k] * center[j], 0));
}

/** Uploads a frame if it is not the one on the card. */
function upload() {
  if (stage.shown === view.frame) return;
  const nodes = frameNodes(view.frame);
  gl.bindBuffer(gl.ARRAY_BUFFER, stage.nodes);
  gl.bufferData(gl.ARRAY_BUFFER, nodes.data, gl.DYNAMIC_DRAW);
  gl.bindBuffer(gl.ARRAY_BUFFER, stage.forces);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(film.frames[view.frame].forces.flat()), gl.DYNAMIC_DRAW);
  const lines = obstacleLines(view.frame);
  const beyond = lines.flatMap(({ ends }) => ends).reduce((most, end) => Math.max(most, Math.hypot(...end)), nodes.reach);
  const spans = nodes.rods.reduce((sum, rod) => sum + Math.max(rod.count - 1, 0), 0);
  Object.assign(stage, { shown: view.frame, current: { ...nodes, data: null, spans, beyond, lines } });
}

/** Lines of all obstacles in a frame, whose images are rows of A and b: x goes to A x + b. A turns the normals and makes them longer;
 * those of planes are zero. */
function obstacleLines(index) {
  const { images } = film.frames[index];
  const image = (rows, end, one) => rows.map((row) => row[0] * end[0] + row[1] * end[1] + row[2] * end[2] + one * row[3]);
  return film.lines.map(({ obstacle, ends, normal }) => ({
    ends: ends.map((end) => image(images[obstacle], end, 1)),
    normal: image(images[obstacle], normal, 0),
  }));
}

/** Ends of the lines on the side that faces the eye: of a ball the near one, of a tube the far one. */
function seenLines() {
  const eye = view.turn[2];
  const faces = ({ normal }) => normal[0] * eye[0] + normal[1] * eye[1] + normal[2] * eye[2] >= 0;
  return stage.current.lines.filter(faces).flatMap(({ ends }) => ends.flat());
}

/** Sets what an input of a program reads: `size` numbers `offset` numbers into records of `stride`. */
function input(at, size, stride, offset, perInstance) {
  if (at === undefined) return;
  gl.enableVertexAttribArray(at);
  gl.vertexAttribPointer(at, size, gl.FLOAT, false, 4 * stride, 4 * offset);
  gl.vertexAttribDivisor(at, perInstance ? 1 : 0);
}

/** Takes a program into use, with the camera set. */
function use(which, lens, aspect) {
  const { made, uniforms } = which;
  gl.useProgram(made);
  gl.uniformMatrix3fv(uniforms.turn, true, view.turn.flat());
  gl.uniform3fv(uniforms.target, view.target);
  gl.uniform4fv(uniforms.lens, lens);
  gl.uniform1f(uniforms.aspect, aspect);
  return which;
}

function surface({ uniforms }, plain, usesPalette) {
  const quantity = film.quantities[view.quantity];
  gl.bindTexture(gl.TEXTURE_2D, stage.palettes[view.quantity]);
  gl.uniform2fv(uniforms.range, quantity.range);
  gl.uniform1f(uniforms.usesPalette, usesPalette ? 1 : 0);
  gl.uniform3fv(uniforms.plain, plain.map((c) => c / 255));
  gl.uniform3fv(uniforms.stripe, film.stripe.map((c) => c / 255));
}

function drawRods(lens, aspect, pixel) {
  const { rods, spans, turning } = stage.current;
  const asLines = spans > MAX_SPANS;
  const which = use(asLines ? stage.line : stage.tube, lens, aspect);
  const { inputs, uniforms } = which;
  const grid = asLines ? null : spanGrid(spans, turning);
  rods.forEach((rod, index) => {
    if (rod.count < 2) return;
    rodSurface(which, index, pixel);
    gl.uniform1f(uniforms.stripeAngle, view.stripe && rod.striped && !asLines ? STRIPE_ANGLE : -1);
    gl.bindBuffer(gl.ARRAY_BUFFER, stage.nodes);
    for (const [end, shift] of [["A", 0], ["B", 1]]) {
      ["point", "tangent", "direction", "values"].forEach((name, k) => {
        input(inputs[name + end], 3, AS_DRAWN, AS_DRAWN * (rod.first + shift) + 3 * k, !asLines);
      });
      input(inputs["radius" + end], 1, AS_DRAWN, AS_DRAWN * (rod.first + shift) + 12, !asLines);
    }
    if (asLines) return gl.drawArrays(gl.LINE_STRIP, 0, rod.count);
    gl.bindBuffer(gl.ARRAY_BUFFER, grid.points);
    input(inputs.corner, 2, 2, 0, false);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, grid.triangles);
    gl.drawElementsInstanced(gl.TRIANGLES, grid.count, gl.UNSIGNED_INT, 0, rod.count - 1);
  });
  release(inputs);
  if (!asLines) drawEnds(lens, aspect, pixel);
}

function rodSurface(which, index, pixel) {
  surface(which, film.strands[index % film.strands.length], view.quantity > 0);
  gl.uniform3fv(which.uniforms.pick, [1, 2, 3].map((k) => (k === view.quantity ? 1 : 0)));
  gl.uniform1f(which.uniforms.pixel, pixel);
}

function drawEnds(lens, aspect, pixel) {
  const which = use(stage.ball, lens, aspect);
  const { inputs, uniforms } = which;
  gl.uniform1f(uniforms.stripeAngle, -1);
  gl.bindBuffer(gl.ARRAY_BUFFER, stage.sphere.points);
  input(inputs.corner, 3, 3, 0, false);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, stage.sphere.triangles);
  gl.bindBuffer(gl.ARRAY_BUFFER, stage.nodes);
  stage.current.rods.forEach((rod, index) => {
    if (film.rods[index].closed || rod.count < 2) return;
    rodSurface(which, index, pixel);
    for (const node of [rod.first, rod.first + rod.count - 1]) {
      input(inputs.pointA, 3, AS_DRAWN, AS_DRAWN * node, true);
      input(inputs.valuesA, 3, AS_DRAWN, AS_DRAWN * node + 9, true);
      input(inputs.radiusA, 1, AS_DRAWN, AS_DRAWN * node + 12, true);
      gl.drawElementsInstanced(gl.TRIANGLES, stage.sphere.count, gl.UNSIGNED_INT, 0, 1);
    }
  });
  release(inputs);
}

function drawForces(lens, aspect) {
  const count = film.frames[view.frame].forces.length;
  if (!view.forces || count === 0) return;
  const which = use(stage.arrow, lens, aspect);
  const { inputs, uniforms } = which;
  surface(which, [214, 60, 48], false);
  gl.uniform1f(uniforms.stripeAngle, -1);
  // by the radii of the step: arrows begin at the surface
  const radius = Math.max(...film.frames[view.frame].radii.flat());
  gl.uniform1f(uniforms.size, (ARROW * radius) / (largestForce || 1));
  gl.uniform1f(uniforms.thick, 0.36 * radius);
  gl.uniform1f(uniforms.off, radius);
  gl.bindBuffer(gl.ARRAY_BUFFER, stage.forces);
  input(inputs.foot, 3, 6, 0, true);
  input(inputs.force, 3, 6, 3, true);
  gl.bindBuffer(gl.ARRAY_BUFFER, stage.cone.points);
  input(inputs.corner, 4, 4, 0, false);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, stage.cone.triangles);
  gl.drawElementsInstanced(gl.TRIANGLES, stage.cone.count, gl.UNSIGNED_INT, 0, count);
  release(inputs);
}

/** Draws the obstacles after all else, behind what is nearer. They leave no depth, so that they neither cast nor take shade. */
function drawObstacles(lens, aspect) {
  const seen = seenLines();
  if (seen.length === 0) return;
  const which = use(stage.line, lens, aspect);
  const { inputs, uniforms } = which;
  surface(which, OBSTACLE, false);
  gl.uniform1f(uniforms.stripeAngle, -1);
  gl.bindBuffer(gl.ARRAY_BUFFER, stage.grid);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(seen), gl.DYNAMIC_DRAW);
  input(inputs.pointA, 3, 3, 0, false);
  gl.depthMask(false);
  gl.drawArrays(gl.LINES, 0, seen.length / 3);
  gl.depthMask(true);
  release(inputs);
}

function release(inputs) {
  Object.values(inputs).forEach((at) => gl.disableVertexAttribArray(at));
}

/** Draws what is to be seen, with the background's colours at the top and the bottom (0 to 1). */
function draw(background) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  resize(Math.max(1, Math.round(canvas.clientWidth * ratio)), Math.max(1, Math.round(canvas.clientHeight * ratio)));
  upload();
  const [width, height] = stage.size;
  const aspect = width / height;
  const reach = stage.current.beyond + Math.hypot(...view.target) + (ARROW + 2) * thickest;
  const lens = [view.distance, Math.max(view.distance - reach, 1e-3 * view.distance), view.distance + reach, LENS];
  gl.viewport(0, 0, width, height);
  gl.bindFramebuffer(gl.FRAMEBUFFER, stage.many);
  gl.clearColor(0, 0, 0, 0);
  gl.enable(gl.DEPTH_TEST);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  drawRods(lens, aspect, 1.3 / (LENS * height) * ratio);
  drawForces(lens, aspect);
  drawObstacles(lens, aspect);
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, stage.many);
  gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, stage.one);
  gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT, gl.NEAREST);
  drawScreen(lens, aspect, background);
}

function drawScreen(lens, aspect, [above, below]) {
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.disable(gl.DEPTH_TEST);
  const { uniforms } = use(stage.screen, lens, aspect);
  gl.activeTexture(gl.TEXTURE1);
  gl.bindTexture(gl.TEXTURE_2D, stage.depth);
  gl.activeTexture(gl.TEXTURE0);
  gl.bindTexture(gl.TEXTURE_2D, stage.drawn);
  gl.uniform1i(uniforms.drawn, 0);
  gl.uniform1i(uniforms.depth, 1);
  gl.uniform3fv(uniforms.above, above);
  gl.uniform3fv(uniforms.below, below);
  gl.uniform1f(uniforms.reach, 3 * thickest);
  gl.uniform1f(uniforms.spread, 1.3 * stage.current.reach);
  gl.uniform1f(uniforms.strength, stage.current.spans > MAX_SPANS ? 0 : 0.85);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
}

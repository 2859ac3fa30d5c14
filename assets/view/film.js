// The film: everything but the nodes is JSON, the nodes of each frame are text in base64, decoded when shown.

const film = JSON.parse(document.getElementById("film").textContent);

/** Numbers of a node in the data: point, direction, pressure, curvature, twist. */
const IN_DATA = 9;
/** Numbers of a node as it is drawn: point, tangent, direction, pressure, curvature, twist, radius. */
const AS_DRAWN = 13;
/** Films of fewer nodes stay decoded. */
const KEPT = 300000;

const numNodes = film.frames.map((frame) => frame.counts.reduce((sum, count) => sum + count, 0));
const keepsFrames = numNodes.reduce((sum, count) => sum + count, 0) < KEPT;

/** The numbers of a frame. */
function numbers(index) {
  const text = atob(document.getElementById("frame" + index).textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = text.charCodeAt(i);
  return new Float32Array(bytes.buffer);
}

/**
 * Nodes of a frame ready to be drawn, and where each rod's are: closed rods have their first node once more at the end,
 * turned by the seam. `turning` is the largest angle (rad) between neighbours, of tangents or directions.
 */
function frameNodes(index) {
  const frame = film.frames[index];
  if (frame.nodes) return frame.nodes;
  const data = frame.data ?? numbers(index);
  const drawn = film.rods.map((rod, r) => frame.counts[r] + (rod.closed && frame.counts[r] > 1 ? 1 : 0));
  const nodes = { data: new Float32Array(AS_DRAWN * drawn.reduce((a, b) => a + b, 0)), rods: [], turning: 0, reach: 0 };
  let [from, to] = [0, 0];
  film.rods.forEach((rod, r) => {
    const source = data.subarray(from, (from += IN_DATA * frame.counts[r]));
    const target = nodes.data.subarray(AS_DRAWN * to, AS_DRAWN * (to + drawn[r]));
    const striped = fill(source, target, rod.closed, frame.seams[r], frame.radii[r]);
    nodes.turning = Math.max(nodes.turning, largestTurning(target));
    nodes.rods.push({ first: to, count: drawn[r], striped });
    to += drawn[r];
  });
  for (let i = 0; i < data.length; i += IN_DATA) nodes.reach = Math.max(nodes.reach, Math.hypot(data[i], data[i + 1], data[i + 2]));
  if (keepsFrames) frame.nodes = nodes;
  return nodes;
}

/** Fills in the nodes of one rod; returns whether it has a material direction. */
function fill(source, target, closed, seam, radii) {
  const count = source.length / IN_DATA;
  const point = (i) => {
    const j = IN_DATA * (closed ? (i + count) % count : Math.min(Math.max(i, 0), count - 1));
    return [source[j], source[j + 1], source[j + 2]];
  };
  let striped = false;
  let before = null;
  for (let k = 0; k < target.length / AS_DRAWN; k++) {
    const i = k % count;
    const j = IN_DATA * i;
    const tangent = tangentOf(point(i - 1), point(i), point(i + 1));
    const given = [source[j + 3], source[j + 4], source[j + 5]];
    striped ||= Math.hypot(...given) > 0.5;
    // without a direction any will do that turns as little as possible along the rod
    let direction = normalTo(tangent, Math.hypot(...given) > 0.5 ? given : before) ?? normalTo(tangent, leastAxis(tangent));
    before = direction;
    // the seam's whole turns are not seen, and without a stripe none
    if (k >= count && striped) direction = turned(direction, tangent, 2 * Math.PI * (seam - Math.round(seam)));
    target.set([...point(i), ...tangent, ...direction, source[j + 6], source[j + 7], source[j + 8], radii[i] ?? radii[0]], AS_DRAWN * k);
  }
  return striped;
}

/** Unit tangent of the circle through three points; the chord's where two are the same. */
function tangentOf(before, here, after) {
  const [into, out] = [sub(here, before), sub(after, here)];
  const [a, b] = [Math.hypot(...into), Math.hypot(...out)];
  if (a === 0 || b === 0) return unit(add(into, out));
  return unit(add(scaled(into, b / a), scaled(out, a / b)));
}

function largestTurning(nodes) {
  let least = 1;
  for (let i = AS_DRAWN; i < nodes.length; i += AS_DRAWN) {
    for (const j of [i + 3, i + 6]) {
      const k = j - AS_DRAWN;
      least = Math.min(least, nodes[j] * nodes[k] + nodes[j + 1] * nodes[k + 1] + nodes[j + 2] * nodes[k + 2]);
    }
  }
  return Math.acos(Math.max(least, -1));
}

// Vectors are arrays of three numbers.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

function unit(a) {
  const length = Math.hypot(...a);
  return length > 0 ? scaled(a, 1 / length) : [1, 0, 0];
}

/** The unit vector normal to a unit tangent that is nearest to a vector; null if there is none. */
function normalTo(tangent, vector) {
  if (!vector) return null;
  const rest = sub(vector, scaled(tangent, dot(tangent, vector)));
  return Math.hypot(...rest) > 1e-6 ? unit(rest) : null;
}

function leastAxis(a) {
  const sizes = a.map(Math.abs);
  const least = sizes.indexOf(Math.min(...sizes));
  return [0, 1, 2].map((k) => (k === least ? 1 : 0));
}

/** A vector normal to a unit axis, turned about it. */
function turned(vector, axis, angle) {
  return add(scaled(vector, Math.cos(angle)), scaled(cross(axis, vector), Math.sin(angle)));
}

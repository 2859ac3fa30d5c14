// The solver in the page: a slider says where the link is to go, the ring follows in steps.

/** The link goes this far either way, turns. */
const MOST_LINK = 4;
/** Older steps are forgotten: the table is made anew at every step. */
const MOST_STEPS = 300;

wasm_bindgen.initSync({ module: Uint8Array.from(atob(byId("module").textContent), (c) => c.charCodeAt(0)) });

/** The ring's thickness, the same in all states. */
const radii = film.frames[0].radii;

let ring = null;
let target = 0;
let moving = false;

/** Takes the ring's state up as the film's last frame and shows it. */
function record() {
  const [data, flat] = [ring.nodes(), Array.from(ring.forces())];
  const forces = Array.from({ length: flat.length / 6 }, (_, k) => flat.slice(6 * k, 6 * k + 6));
  film.rows.push(Array.from(ring.row(), (x) => (Number.isNaN(x) ? null : x)));
  film.frames.push({ step: 0, counts: [data.length / IN_DATA], radii, seams: [ring.excessLink], forces, data });
  if (film.rows.length > MOST_STEPS) {
    film.rows.shift();
    film.frames.shift();
  }
  film.frames.forEach((frame, k) => (frame.step = k));
  widen(data, forces);
  remakePanel();
  stage.shown = -1;
  show(film.frames.length - 1);
}

/** Lets the colour bars and the longest arrow span all states so far. */
function widen(data, forces) {
  for (let k = 1; k < film.quantities.length; k++) {
    const { range } = film.quantities[k];
    for (let i = IN_DATA - 4 + k; i < data.length; i += IN_DATA) range[1] = Math.max(range[1], Math.abs(data[i]));
    if (range[0] < 0) range[0] = -range[1];
  }
  largestForce = Math.max(largestForce, ...forces.map((force) => Math.hypot(...force.slice(3))));
  showQuantity(view.quantity);
}

function remakePanel() {
  byId("plots").replaceChildren();
  byId("table").replaceChildren();
  mark = makePanel(choose);
}

/** One step a picture, until the ring is where it is to be. */
function follow() {
  moving = Math.abs(target - ring.excessLink) > 1e-9;
  if (!moving) return tell("at rest");
  if (!ring.stepTowards(target)) {
    moving = false;
    return tell("does not converge from here");
  }
  record();
  tell("on its way");
  requestAnimationFrame(follow);
}

function tell(how) {
  byId("fate").textContent = `${signed(target.toFixed(2))} turns · ${how}`;
}

function turnLink(to) {
  target = to;
  if (!moving) {
    moving = true;
    requestAnimationFrame(follow);
  }
}

/** Back to the relaxed circle. */
function begin() {
  ring?.free();
  ring = new wasm_bindgen.Minicircle();
  film.rows.length = film.frames.length = 0;
  byId("turns").value = target = 0;
  record();
  tell("at rest");
}

function startLive() {
  const turns = element("input", { type: "range", id: "turns", min: -MOST_LINK, max: MOST_LINK, step: 0.05, value: 0 });
  const circle = element("button", { id: "begin", title: "Back to the relaxed circle" }, "Circle");
  const label = element("label", { for: "turns" }, "Excess link");
  document.querySelector("main").append(element("div", { id: "link" }, label, turns, element("output", { id: "fate" }), circle));
  turns.addEventListener("input", () => turnLink(Number(turns.value)));
  circle.addEventListener("click", begin);
  byId("forces").parentElement.hidden = false;
  byId("quantity").options[1].hidden = false;
  for (const quantity of film.quantities.slice(1)) quantity.range = quantity.range.map((x) => 1e-9 * Math.sign(x));
  turnBy(0, -0.9);
  begin();
  fit();
  // the supercoil is longer than the circle is high
  view.distance *= 1.35;
}

if (drawable) startLive();

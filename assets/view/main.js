// Controls.

/** Seconds in which a film plays, and the least and most that a step is shown, ms. */
const PLAYED = 6000, SHORTEST = 60, LONGEST = 300;

/** Columns that are told above the picture. */
const TOLD = ["excess_link", "writhe", "twist", "num_sites", "contact_force"];

let due = false;
/** Draws at the next opportunity, once. */
function redraw() {
  if (due) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    draw(background());
  });
}

function background() {
  const style = getComputedStyle(document.documentElement);
  const channels = (hex) => [1, 3, 5].map((k) => parseInt(hex.trim().slice(k, k + 2), 16) / 255);
  return ["--above", "--below"].map((name) => channels(style.getPropertyValue(name)));
}

function show(index) {
  view.frame = Math.max(0, Math.min(index, film.frames.length - 1));
  const frame = film.frames[view.frame];
  byId("step").value = view.frame;
  byId("count").value = `step ${frame.step} of ${film.rows.length - 1}`;
  const row = film.rows[frame.step];
  const parts = film.columns.flatMap(({ name, unit }, k) => {
    if (!row || !TOLD.includes(name)) return [];
    return [`${name} `, element("b", {}, cell(row, k, 3)), unit === "turns" || !unit ? "" : ` ${unit}`, " · "];
  });
  byId("state").replaceChildren(...parts.slice(0, -1));
  mark(frame.step);
  redraw();
}

function showQuantity(index) {
  view.quantity = index;
  const { label, unit, range, colors } = film.quantities[index];
  byId("scale").hidden = index === 0;
  byId("scale-label").textContent = withUnit({ name: label, unit });
  byId("scale-colors").style.background = `linear-gradient(90deg, ${colors.map((c) => `rgb(${c})`)})`;
  [byId("scale-low").textContent, byId("scale-high").textContent] = range.map((x) => readable(x, 3));
  redraw();
}

let playing = null;
function play(on) {
  clearInterval(playing);
  playing = null;
  if (on && film.frames.length > 1) {
    if (view.frame === film.frames.length - 1) show(0);
    playing = setInterval(() => {
      if (view.frame === film.frames.length - 1) play(false);
      else show(view.frame + 1);
    }, Math.max(SHORTEST, Math.min(LONGEST, PLAYED / film.frames.length)));
  }
  byId("play").classList.toggle("on", playing !== null);
  byId("play").ariaLabel = playing ? "pause" : "play";
}

/** Turns what is seen by angles (rad) about the screen's axes. */
function turnBy(right, up, roll = 0) {
  const rotate = (i, j, angle) => {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const [a, b] = [view.turn[i], view.turn[j]];
    view.turn[i] = sub(scaled(a, c), scaled(b, s));
    view.turn[j] = add(scaled(a, s), scaled(b, c));
  };
  rotate(2, 0, right);
  rotate(1, 2, up);
  rotate(0, 1, roll);
  view.turn[0] = unit(view.turn[0]);
  view.turn[2] = unit(cross(view.turn[0], view.turn[1]));
  view.turn[1] = cross(view.turn[2], view.turn[0]);
}

/** Moves what is seen by pixels. */
function moveBy(dx, dy) {
  const size = (2 * view.distance) / (LENS * canvas.clientHeight);
  view.target = add(view.target, add(scaled(view.turn[0], -dx * size), scaled(view.turn[1], dy * size)));
}

function zoomBy(factor, event) {
  const box = canvas.getBoundingClientRect();
  const off = [event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2];
  // the point under the pointer stays
  moveBy(-off[0], -off[1]);
  view.distance = Math.max(1e-3 * film.extent, Math.min(100 * film.extent, view.distance * factor));
  moveBy(off[0], off[1]);
}

function listenToPointers() {
  const held = new Map();
  const spread = () => {
    const [a, b] = [...held.values()];
    return b ? [Math.hypot(a.x - b.x, a.y - b.y), (a.x + b.x) / 2, (a.y + b.y) / 2] : null;
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = held.get(event.pointerId);
    if (!last) return;
    const [dx, dy, before] = [event.clientX - last.x, event.clientY - last.y, spread()];
    held.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const after = spread();
    if (before) {
      zoomBy(before[0] / Math.max(after[0], 1), { clientX: after[1], clientY: after[2] });
      moveBy(after[1] - before[1], after[2] - before[2]);
    } else if (event.shiftKey || event.buttons & 6) moveBy(dx, dy);
    else turnBy((5 * dx) / canvas.clientHeight, (5 * dy) / canvas.clientHeight);
    redraw();
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => held.delete(event.pointerId));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", refit);
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomBy(Math.exp(0.0012 * event.deltaY * (event.deltaMode ? 30 : 1)), event);
    redraw();
  }, { passive: false });
}

function refit() {
  fit();
  redraw();
}

/** Saves what is seen, with its colour bar, as a PNG file. */
function savePicture() {
  draw(background());
  const picture = element("canvas", { width: canvas.width, height: canvas.height });
  const pen = picture.getContext("2d");
  pen.drawImage(canvas, 0, 0);
  const ratio = canvas.width / canvas.clientWidth;
  pen.scale(ratio, ratio);
  if (view.quantity > 0) drawScale(pen, canvas.clientWidth);
  const name = (film.title || "supercoil").toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "").slice(0, 40);
  const link = element("a", { download: `${name}-step-${film.frames[view.frame].step}.png` });
  link.href = picture.toDataURL("image/png");
  link.click();
}

function drawScale(pen, width) {
  const { label, unit, range, colors } = film.quantities[view.quantity];
  const left = width - 234;
  const fill = pen.createLinearGradient(left, 0, left + 210, 0);
  colors.forEach((c, k) => fill.addColorStop(k / (colors.length - 1), `rgb(${c})`));
  pen.fillStyle = fill;
  pen.fillRect(left, 42, 210, 10);
  pen.fillStyle = getComputedStyle(document.body).color;
  pen.font = "12px sans-serif";
  pen.fillText(withUnit({ name: label, unit }), left, 34);
  pen.fillText(readable(range[0], 3), left, 68);
  pen.textAlign = "right";
  pen.fillText(readable(range[1], 3), left + 210, 68);
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  byId("theme").textContent = theme === "dark" ? "Light" : "Dark";
  if (drawable) redraw();
}

function toggleNumbers() {
  const hidden = (byId("panel").hidden = !byId("panel").hidden);
  byId("numbers").ariaPressed = String(!hidden);
}

function listenToControls() {
  const toggleTheme = () => setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  byId("step").addEventListener("input", (event) => { play(false); show(Number(event.target.value)); });
  byId("play").addEventListener("click", () => play(!playing));
  byId("quantity").addEventListener("change", (event) => showQuantity(event.target.selectedIndex));
  for (const name of ["forces", "stripe"]) {
    byId(name).addEventListener("change", (event) => { view[name] = event.target.checked; redraw(); });
  }
  byId("fit").addEventListener("click", refit);
  byId("picture").addEventListener("click", savePicture);
  byId("theme").addEventListener("click", toggleTheme);
  byId("numbers").addEventListener("click", toggleNumbers);
  const keys = {
    " ": () => play(!playing), f: refit, s: savePicture, t: toggleTheme, n: toggleNumbers,
    ArrowRight: () => show(view.frame + 1), ArrowLeft: () => show(view.frame - 1),
    Home: () => show(0), End: () => show(film.frames.length - 1),
  };
  addEventListener("keydown", (event) => {
    const inControl = event.target.closest("input, select, button");
    if (inControl || event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
}

/** Whether there is anything to be drawn, and with what. */
const drawable = gl !== null && film.frames.length > 0;

/** What a click on a row of the table or on a plot does. */
function choose(row) {
  if (!drawable) return mark(row);
  play(false);
  show(frameOfRow(row));
}

let mark = makePanel(choose);

function start() {
  setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  if (!drawable) {
    const reason = gl ? "There is no step to be shown." : "This page draws with WebGL 2, which this browser does not offer. The numbers are complete.";
    document.querySelector("main").replaceChildren(element("p", { class: "failure" }, reason));
    return;
  }
  byId("title").textContent = film.title;
  film.quantities.forEach(({ name, label }) => byId("quantity").append(element("option", { value: name }, label)));
  byId("step").max = film.frames.length - 1;
  byId("player").hidden = film.frames.length < 2;
  const anyForce = film.frames.some((frame) => frame.forces.length > 0);
  byId("forces").parentElement.hidden = !anyForce;
  byId("forces").checked = view.forces;
  if (!anyForce) byId("quantity").options[1].hidden = true;
  fit();
  showQuantity(0);
  show(view.frame);
  listenToPointers();
  listenToControls();
  new ResizeObserver(redraw).observe(canvas);
}

start();

// Numbers beside the picture: plots and table, linked to the step.

/** Colours of the lines, see the style sheet. */
const SERIES = ["var(--first)", "var(--second)", "var(--third)"];
/** Size of a plot in its own units, and the margins of its axes: left, right, top, bottom. */
const PLOT = { width: 394, height: 132, margins: [46, 8, 8, 20] };

const byId = (id) => document.getElementById(id);

function element(name, attributes = {}, ...children) {
  const svg = ["svg", "path", "line", "circle", "text", "g"].includes(name);
  const made = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** Text of a number with a true minus; what rounds to zero has none. */
function signed(text) {
  const number = /[1-9]/.test(text.split("e")[0]) ? text : text.replace("-", "");
  return number.replace("e+", "e").replaceAll("-", "−");
}

/** A number as people read it: plain where that shows its digits, else in powers of ten. */
function readable(x, digits = 4) {
  if (x === null || x === undefined) return "–";
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size < 1e-3 || size >= 1e6) return signed(x.toExponential(2));
  return signed(x.toFixed(Math.max(0, Math.min(digits, digits - Math.floor(Math.log10(size))))));
}

/** Which columns count something; see `makePanel`. */
let counts = [];

/** A number of the table as text. */
function cell(row, k, digits) {
  if (film.columns[k].unit === "turns" && row[k] !== null) return signed(row[k].toFixed(4));
  return counts[k] && row[k] !== null ? signed(String(row[k])) : readable(row[k], digits);
}

const withUnit = ({ name, unit }) => (unit ? `${name}, ${unit}` : name);

/** Frame nearest to a row of the table. */
function frameOfRow(row) {
  const distance = (frame) => Math.abs(frame.step - row);
  return film.frames.reduce((best, frame, k) => (distance(frame) < distance(film.frames[best]) ? k : best), 0);
}

/** Marks of an axis: some three to six round numbers. */
function ticks(low, high, most) {
  const rough = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((k) => k >= rough);
  const marks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) marks.push(k * step);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const text = (x) => signed(Math.abs(x) >= 1e6 || (x !== 0 && step < 1e-4) ? x.toExponential(1) : x.toFixed(decimals));
  return marks.map((x) => [x, text(Math.abs(x) < 1e-9 * step ? 0 : x)]);
}

/** Draws a plot; returns what moves its mark to a row. */
function makePlot({ x, y }, choose) {
  const { width, height, margins: [left, right, top, bottom] } = PLOT;
  const column = (k) => film.rows.map((row) => row[k]);
  const xs = column(x);
  const all = y.flatMap(column).filter((v) => v !== null);
  const range = (values) => {
    const [low, high] = [Math.min(...values), Math.max(...values)];
    return low < high ? [low, high] : [low - 1, high + 1];
  };
  const [[x0, x1], [y0, y1]] = [range(xs), range(all)];
  const px = (v) => left + ((v - x0) / (x1 - x0)) * (width - left - right);
  const py = (v) => height - bottom - ((v - y0) / (y1 - y0)) * (height - top - bottom);
  const svg = element("svg", { viewBox: `0 0 ${width} ${height}` });
  for (const [v, text] of ticks(y0, y1, 4)) {
    svg.append(element("line", { class: "grid", x1: left, x2: width - right, y1: py(v), y2: py(v) }));
    svg.append(element("text", { x: left - 6, y: py(v) + 3.5, "text-anchor": "end" }, text));
  }
  for (const [v, text] of ticks(x0, x1, 6)) svg.append(element("text", { x: px(v), y: height - 5, "text-anchor": "middle" }, text));
  const now = element("line", { class: "now", y1: top, y2: height - bottom });
  svg.append(now);
  const marks = y.map((k, index) => {
    const points = film.rows.map((row) => (row[k] === null ? null : [px(row[x]), py(row[k])]));
    const path = points.map((p, i) => (p ? `${points[i - 1] ? "L" : "M"}${p[0].toFixed(1)} ${p[1].toFixed(1)}` : "")).join("");
    const mark = element("circle", { r: 3.5, style: `fill: ${SERIES[index]}` });
    svg.append(element("path", { d: path, style: `stroke: ${SERIES[index]}` }), mark);
    return { mark, points };
  });
  const pointed = (event) => {
    const box = svg.getBoundingClientRect();
    const at = ((event.clientX - box.left) / box.width) * width;
    choose(xs.reduce((best, v, i) => (Math.abs(px(v) - at) < Math.abs(px(xs[best]) - at) ? i : best), 0));
  };
  svg.addEventListener("pointerdown", (event) => { svg.setPointerCapture(event.pointerId); pointed(event); });
  svg.addEventListener("pointermove", (event) => { if (event.buttons) pointed(event); });
  const caption = element("figcaption");
  y.forEach((k, index) => {
    const name = element("b", { style: `color: ${SERIES[index]}` }, film.columns[k].name);
    caption.append(...(index ? [" and ", name] : [name]));
  });
  caption.append(`${film.columns[y[0]].unit ? ", " + film.columns[y[0]].unit : ""}, against ${withUnit(film.columns[x])}`);
  byId("plots").append(element("figure", {}, caption, svg));
  return (row) => {
    now.setAttribute("x1", px(xs[row]));
    now.setAttribute("x2", px(xs[row]));
    for (const { mark, points } of marks) {
      mark.style.display = points[row] ? "" : "none";
      if (points[row]) { mark.setAttribute("cx", points[row][0]); mark.setAttribute("cy", points[row][1]); }
    }
  };
}

/** Makes the table; returns what marks a row. */
function makeTable(choose) {
  const head = film.columns.map(({ name, unit }) => element("th", {}, name, element("small", {}, unit)));
  const rows = film.rows.map((row, index) => {
    const made = element("tr", {}, ...row.map((_, k) => element("td", {}, cell(row, k))));
    made.addEventListener("click", () => choose(index));
    return made;
  });
  byId("table").append(element("table", {}, element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows)));
  let before = null;
  return (index) => {
    before?.classList.remove("now");
    before = rows[index];
    before?.classList.add("now");
    before?.scrollIntoView({ block: "nearest", inline: "nearest" });
  };
}

/** Fills the panel; returns what marks a row everywhere. `choose` is called with the row that was pointed at. */
function makePanel(choose) {
  counts = film.columns.map((_, k) => film.rows.every((row) => row[k] === null || Number.isInteger(row[k])));
  const plots = film.rows.length > 1 ? film.plots.map((plot) => makePlot(plot, choose)) : [];
  const table = makeTable(choose);
  byId("note").textContent = [film.note, film.program].filter(Boolean).join(" · ");
  return (row) => [...plots, table].forEach((mark) => mark(row));
}

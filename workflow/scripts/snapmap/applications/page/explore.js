"use strict";
// Fills the page's two figures: the map over two axes at the sliders' places on all others, and the
// history of the chosen cell.

const study = JSON.parse(document.getElementById("data").textContent);
const { axes } = study;
const [map, motion, room] = ["map", "history", "motion"].map((id) => document.getElementById(id));
const [X, Y, PULSE] = [study.x, study.y, "f0"].map((key) => axes.findIndex(({ name }) => name === key));
const strides = axes.map((_, n) => axes.slice(n + 1).reduce((cells, { values }) => cells * values.length, 1));
const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const STEPS = [[X, [["ArrowLeft", "←"], ["ArrowRight", "→"]]], [Y, [["ArrowDown", "↓"], ["ArrowUp", "↑"]]]];
const LINES = [1, 2, 3], APART = 4, CHOSEN = [5, 6]; // curves of the map, after the cells
const SNAPPED = study.views[0].states.findIndex(({ name }) => name === "snapped");
const KINDS = { uint8: Uint8Array, float32: Float32Array };
const ends = study.views.find(({ name }) => name === "end") ?? study.views[0]; // of which words tell
let view = study.views[0]; // what the map shows
const cells = {}; // arrays over the cells; the thresholds' are over the rows of cells along N
const at = study.start; // the chosen cell's place on each axis

const PLAIN = {
  font: { family: "system-ui, sans-serif", size: 12, color: "#242424" },
  hoverlabel: { bgcolor: "white", align: "left" },
  hovermode: "closest",
  showlegend: false,
  margin: { l: 60, r: 12, t: 30, b: 50 },
};
const AXIS = { showline: true, linecolor: "#242424", ticks: "outside", showgrid: false, zeroline: false, automargin: true };
const BUTTONS = {
  responsive: true,
  displaylogo: false,
  showSendToCloud: false, // a button that uploads the study
  plotlyServerURL: "",
  doubleClick: "reset", // also what two quick clicks on two cells do
  modeBarButtonsToRemove: ["select", "lasso", "autoScale"],
};
const [BAND, BEAM, TOTAL, AID] = ["rgba(0, 114, 178, 0.35)", "#0072b2", "#d55e00", "#555555"];
const DASHES = { dash: "8 4", dot: "2 2", dashdot: "8 3 2 3", longdash: "12 4" }; // of plotly's what SVG takes
const TICKS = 6; // at most, so that they stand apart on a phone

async function unpack({ kind, bytes }) {
  const packed = Uint8Array.from(atob(bytes), (sign) => sign.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new KINDS[kind](await new Response(stream).arrayBuffer());
}

const round = (value) => String(Number(value.toPrecision(4)));
const say = (n, place) => axes[n].lead + axes[n].texts[place];
const state = (k) => ends.states[cells[ends.code][k]];
const outcome = (k) => study.outcomes[cells.outcome[k]];
const isOpen = (k) => ["unsnapped", "snapped"].includes(outcome(k).name);
const isAbsent = (k) => outcome(k).name === "absent";
const rowOf = (k) => Math.floor(k / axes.at(-1).values.length);

// Round numbers, to a decade 1, 2 and 5 or fewer; between close ends evenly spaced.
function roundBetween(low, high) {
  const decades = Array.from({ length: Math.ceil(Math.log10(high / low)) + 1 }, (_, n) => 10 ** (Math.floor(Math.log10(low)) + n));
  const sets = [[1, 2, 5], [1, 3], [1]].map((digits) =>
    decades.flatMap((decade) => digits.map((digit) => digit * decade)).filter((tick) => tick >= low && tick <= high));
  if (high > 4 * low) return sets.find((ticks) => ticks.length <= TICKS) ?? sets[2];
  const unit = 10 ** Math.floor(Math.log10((high - low) / 4));
  const step = unit * [1, 2, 5, 10].find((digit) => 4 * digit * unit >= high - low);
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.floor(high / step) - first + 1 }, (_, n) => (first + n) * step);
}

function scaleOf({ label, unit, type, values, edges, ticked, bare }) {
  const [low, high] = [edges[0], edges.at(-1)];
  const range = type === "log" ? [Math.log10(low), Math.log10(high)] : [low, high];
  const scale = { ...AXIS, title: { text: unit ? `${label} (${unit})` : label }, type, range, exponentformat: "none" };
  const kept = (_, n) => n % ticked === 0;
  if (ticked) return { ...scale, tickvals: values.filter(kept), ticktext: bare.filter(kept) };
  if (type === "linear") return scale;
  const ticks = roundBetween(low, high);
  return { ...scale, tickvals: ticks, ticktext: ticks.map(round) };
}

// Above frequencies (Hz): durations (ms).
function durations({ values, edges }) {
  const ticks = values.length > 1 ? roundBetween(1e3 / edges.at(-1), 1e3 / edges[0]) : [1e3 / values[0]];
  const title = { text: "pulse duration 1/f<sub>0</sub> (ms)", standoff: 4 };
  const above = { overlaying: "x", matches: "x", side: "top", title };
  return { ...above, tickvals: ticks.map((tick) => 1e3 / tick), ticktext: ticks.map(round) };
}

// The map without cells, colours and lines, which are filled in as chosen.
function openMap() {
  const bare = { type: "scatter", hoverinfo: "skip" };
  const pale = "rgba(255, 255, 255, 0.6)";
  const ring = { symbol: "circle-open", size: 15, color: "black", line: { width: 2 } };
  const marks = [{ symbol: "line-ne-open", size: 7, color: "#333333" }, { ...ring, color: "white", line: { width: 5 } }, ring];
  const always = { symbol: "line-ew-open", size: 9, color: "black" };
  const curves = [
    { type: "heatmap", x: axes[X].edges, y: axes[Y].edges, zmin: -0.5, showscale: false, hovertemplate: "%{text}<extra></extra>" },
    // As LINES: from where all snap; the band of error about where the first snap; and where they do.
    { ...bare, mode: "lines+markers", line: { color: "black", width: 1 }, marker: always },
    { ...bare, mode: "lines", line: { color: pale, width: 3 }, fill: "toself", fillcolor: pale },
    { ...bare, mode: "lines+markers", line: { color: "black", width: 1.5 }, marker: { size: 3, color: "black" } },
    ...marks.map((marker) => ({ ...bare, mode: "markers", marker })),
  ];
  const layout = { ...PLAIN, xaxis: scaleOf(axes[X]), yaxis: scaleOf(axes[Y]) };
  if (X === PULSE) {
    curves.push({ ...bare, x: [null], y: [null], xaxis: "x2" }); // no axis is shown without a curve
    layout.xaxis2 = { ...layout.xaxis, ...durations(axes[X]) };
    layout.margin = { ...PLAIN.margin, t: 84 };
  }
  return Plotly.newPlot(map, curves, layout, BUTTONS);
}

// Positions and energies; the curves are as `traced`.
function openMotion() {
  const line = (name, color, width, more) => ({
    type: "scatter", mode: "lines", name, line: { color, width }, x: [0], y: [0],
    hovertemplate: "%{y:.3g} at %{x:.3g} ms", ...more,
  });
  const energy = { yaxis: "y2" };
  const curves = [
    line("w(L/2), least", BEAM, 0.7),
    line("midpoint w(L/2)", BEAM, 0.7, { fill: "tonexty", fillcolor: BAND }),
    line("mass z<sub>M</sub>", "#000000", 1.5),
    line("energy", TOTAL, 1.5, energy),
    line("beam's energy", BEAM, 1, energy),
  ];
  const mark = (name, dash, at) => ({ type: "line", name, line: { color: AID, width: 1.2, dash }, ...at });
  const w2 = cells.second.reduce((low, w) => (w < low ? w : low), 0);
  const level = { xref: "x domain", x0: 0, x1: 1 };
  const instant = { xref: "x", x0: 0, x1: 0, yref: "paper", y0: 0, y1: 1 };
  const shapes = [
    mark("second shape w<sub>2</sub>", "dash", { ...level, yref: "y", y0: w2, y1: w2 }),
    mark("saddle", "solid", { ...level, yref: "y2", y0: 1, y1: 1 }),
    mark("end of the pulse", "dot", instant),
    mark("snap", "dashdot", instant),
    mark("settled", "longdash", instant),
  ];
  const stroke = ({ color, width, dash }) =>
    `<path d="M0 6H28" stroke="${color}" stroke-width="${width}" stroke-dasharray="${DASHES[dash] ?? "none"}"/>`;
  // A list of its own: it wraps on a phone, where plotly's legend does not.
  document.getElementById("lines").innerHTML = [...curves.slice(1), ...shapes].map(({ name, line: own, fill }) =>
    `<li><svg width="28" height="12" fill="none" aria-hidden="true">${stroke(own)}${
      fill ? stroke({ color: BAND, width: 9 }) : ""}</svg> ${name}</li>`).join("");
  const upright = (text, domain, include) => ({ ...AXIS, title: { text }, domain, autorangeoptions: { include } });
  return Plotly.newPlot(motion, curves, {
    ...PLAIN,
    shapes,
    xaxis: { ...AXIS, title: { text: "time after the start of the pulse (ms)" }, anchor: "y2" },
    yaxis: upright("position (µm)", [0.45, 1], [1.15 * w2, -1.15 * w2]),
    yaxis2: upright("energy / saddle's", [0, 0.4], [0, 1.2]),
  }, BUTTONS);
}

function place(i, j) {
  const rest = at.map((own, n) => (n === X ? i : n === Y ? j : own));
  return rest.reduce((k, own, n) => k + own * strides[n], 0);
}

function byCell(make) {
  const corner = place(0, 0);
  return axes[Y].values.map((_, j) =>
    axes[X].values.map((_, i) => make(corner + i * strides[X] + j * strides[Y], i, j)));
}

function describe(k, i, j) {
  const snap = cells.t_snap[k];
  const lines = [`<b>${state(k).words}</b>`, ...ending(k), say(Y, j), say(X, i)];
  if (isAbsent(k)) return lines.join("<br>");
  lines.push(Number.isNaN(snap) ? "no snap" : `t<sub>snap</sub> = ${round(snap)} µs`);
  return lines.concat(cells.elsewhere[k] ? ["another step ended elsewhere"] : []).join("<br>");
}

// What a cell's colour leaves out, in lines.
function ending(k) {
  const { words } = outcome(k);
  if (words === state(k).words) return [];
  if (!isOpen(k)) return [words];
  return cells.well[k] ? [words, ...side(k)] : [];
}

function side(k) {
  const well = ["", "first", "second"][cells.well[k]];
  const share = cells.share[k] < study.whole ? `during ${Math.floor(100 * cells.share[k])} %` : "for the whole";
  return [`on the ${well} side ${share}`, "of the mass's last swing"];
}

function drawMap() {
  const apart = byCell((k, i, j) => (view === ends && cells.elsewhere[k] ? [[i, j]] : [])).flat(2);
  const codes = byCell((k) => cells[view.code][k]);
  const hasLines = axes[Y].name === "N" && view.name === "snap";
  const lines = hasLines ? thresholds() : LINES.map(() => ({ x: [], y: [] }));
  listClasses(codes.flat(), apart.length, lines.map(({ y }) => y.some(Number.isFinite)));
  const layers = { x: lines.map(({ x }) => x), y: lines.map(({ y }) => y) };
  Plotly.restyle(map, layers, LINES);
  const inks = apart.map(([i, j]) => inkOn(view.states[codes[j][i]].colour));
  Plotly.restyle(map, { ...marksAt(apart), "marker.color": [inks] }, [APART]);
  const colours = { colorscale: [view.scale], zmax: view.states.length - 0.5 };
  const z = byCell((k) => cells[view.code][k] + (view.ramp && cells.snap[k] === SNAPPED ? shade(k) : 0));
  Plotly.restyle(map, { z: [z], text: [byCell(describe)], ...colours }, [0]);
}

// Where a cell that snaps stands among the colours of times, nearly from -0.5 to 0.5.
function shade(k) {
  const [first, last] = snapTimes();
  const scaled = last > study.wide * first ? Math.log : (time) => time;
  const share = (scaled(cells.t_snap[k]) - scaled(first)) / (scaled(last) - scaled(first) || 1);
  return 0.98 * (share - 0.5);
}

// The first and the last snap of all cells, us.
function snapTimes() {
  cells.ends ??= cells.t_snap.reduce(([first, last], time) =>
    (Number.isNaN(time) ? [first, last] : [Math.min(first, time), Math.max(last, time)]), [Infinity, 0]);
  return cells.ends;
}

// N_always where it is another, the band of N_first's error, and N_first along the map's x.
function thresholds() {
  const x = axes[X].values;
  const [N, error, always] = ["N_first", "N_error", "N_always"].map((key) =>
    x.map((_, i) => cells[key][rowOf(place(i, 0))]));
  const known = (bar) => (Number.isFinite(bar) ? bar : 0);
  const band = { x: [], y: [] };
  const close = (from, to) => {
    const there = Array.from({ length: to - from }, (_, n) => from + n);
    const back = [...there].reverse();
    band.x.push(...[...there, ...back].map((i) => x[i]), null);
    band.y.push(...there.map((i) => N[i] + error[i]), ...back.map((i) => N[i] - error[i]), null);
  };
  let from = 0;
  for (let i = 0; i <= x.length; i += 1) {
    if (Number.isFinite(N[i] + error[i])) continue;
    if (i > from) close(from, i);
    from = i + 1;
  }
  return [{ x, y: always.map((all, i) => (all > N[i] + known(error[i]) ? all : null)) }, band, { x, y: N }];
}

function inkOn(colour) {
  const [red, green, blue] = [1, 3, 5].map((n) => parseInt(colour.slice(n, n + 2), 16));
  return 0.3 * red + 0.6 * green + 0.1 * blue < 110 ? "#ffffff" : "#333333";
}

function marksAt(places) {
  return { x: [places.map(([i]) => axes[X].values[i])], y: [places.map(([, j]) => axes[Y].values[j])] };
}

function listClasses(codes, apart, [hasAlways, , hasFirst]) {
  const items = view.states.map(({ words, colour }, code) => {
    const count = codes.filter((other) => other === code).length;
    const key = view.ramp && code === SNAPPED ? timeKey() : `<i style="background:${colour}"></i>${words}`;
    return count ? `<li>${key} (${count})</li>` : "";
  });
  if (apart) items.push(`<li><i class="apart"></i>another step ended elsewhere (${apart})</li>`);
  if (hasFirst) items.push('<li><i class="line"></i>lowest N that snaps, with its error</li>');
  if (hasAlways) items.push('<li><i class="line always"></i>N above which all snap</li>');
  document.getElementById("classes").innerHTML = items.join("");
}

function timeKey() {
  const [first, last] = snapTimes().map((time) => `${round(time / 1e3)} ms`);
  return `${first} <i class="ramp" style="background:linear-gradient(to right, ${view.ramp})"></i>${last}, first snap`;
}

function trace(name, k) {
  const [scale, offset] = [cells[`${name}_scale`][k], cells[`${name}_offset`][k]];
  let code = 0; // the bytes are differences between codes
  return Array.from(cells[name].subarray(k * study.bins, (k + 1) * study.bins), (step) => {
    code = (code + step) % 256;
    return code === study.missing ? null : offset + scale * code;
  });
}

function drawHistory() {
  const k = place(at[X], at[Y]);
  const values = axes.map((_, n) => `<span>${say(n, at[n])}</span>`);
  document.getElementById("cell").innerHTML = values.reverse().join(", ");
  document.getElementById("edge").textContent = isAbsent(k) ? "" : threshold(rowOf(k));
  document.getElementById("verdict").innerHTML = `<b>${state(k).words}:</b> ${verdict(k)}`;
  drawDevice();
  const wasHidden = room.hidden;
  room.hidden = isAbsent(k) || !study.bins;
  if (room.hidden) return;
  const starts = Array.from({ length: study.bins }, (_, bin) => (bin * cells.bin_length[k]) / 1e3);
  const middles = starts.map((start) => start + cells.bin_length[k] / 2e3);
  const end = 1e6 / axes[PULSE].values[at[PULSE]];
  const instants = [end, cells.t_snap[k], cells.t_settled[k]].map((time) => time / 1e3);
  const instantKeys = [...document.getElementById("lines").children].slice(-instants.length);
  instantKeys.forEach((key, n) => { key.hidden = Number.isNaN(instants[n]); });
  const [second, saddle, ...marks] = motion.layout.shapes;
  const moved = marks.map((mark, n) => ({ ...mark, ...standing(instants[n]) }));
  const curves = { x: [middles, middles, starts, starts, starts], y: study.traced.map((name) => trace(name, k)) };
  const whole = { "xaxis.autorange": true, "yaxis.autorange": true, "yaxis2.autorange": true };
  const level = { ...second, y0: cells.second[k], y1: cells.second[k] };
  Plotly.update(motion, curves, { shapes: [level, saddle, ...moved], ...whole });
  if (wasHidden) Plotly.Plots.resize(motion); // the window may have changed meanwhile
}

function standing(time) {
  return Number.isNaN(time) ? { visible: false } : { visible: true, x0: time, x1: time };
}

function threshold(row) {
  const [N, error, always] = [cells.N_first[row], cells.N_error[row], cells.N_always[row]];
  if (Number.isNaN(N)) return "Here nothing snaps at any N looked at.";
  const bar = Number.isFinite(error) ? `\u00a0±\u00a0${Number(error.toPrecision(2))}` : "";
  const all = always > N ? `; above ${Number(always.toPrecision(5))} all snap` : "";
  return `Here the lowest N that snaps is ${Number(N.toPrecision(5))}${bar}${all}.`;
}

function verdict(k) {
  if (isAbsent(k)) return "the beam of this device springs back wherever it is pushed; nothing was simulated.";
  const snap = `the midpoint reached the ${study.shapes[1]} equilibrium at t = ${round(cells.t_snap[k])} µs`;
  const proven = `proven at t = ${round(cells.t_settled[k])} µs`;
  const fell = "the energy fell below the saddle";
  const apart = "the beam's own energy fell below the saddle, and the mass swings too weakly to touch it again";
  const kept = cells.well[k] ? `; it was ${side(k).join(" ")}` : "";
  const open = `${kept}; what follows is open${study.bins ? `: ${left(cells.energy_at_end[k])}` : ""}`;
  // After the pulse the energy only falls: if it is above the saddle after the proof, so it was then.
  const why = cells.energy_at_proof?.[k] > 1 ? apart : fell;
  const doubt = cells.elsewhere[k] ? " With another step it ended elsewhere." : "";
  return {
    unsnapped: `no snap within ${round(study.horizon / 1e3)} ms after the pulse${open}.`,
    never: `no snap, ${proven}: after the pulse nothing adds to the energy, and ${why === fell ? "it is below the saddle" : why}.`,
    snapped: `${snap}${open}.`,
    latched: `${snap}; that it stays is ${proven}${study.bins ? `: ${why}` : ""}.`,
    returned: `${snap}; that it is back in the ${study.shapes[0]} shape for ever is ${proven}: ${why}.`,
    failed: "the run blew up or its energy ledger did not close; nothing is claimed of this cell.",
  }[outcome(k).name] + doubt + withAnotherStep(k);
}

function withAnotherStep(k) {
  const [work, snap] = [cells.work_error[k], cells.t_snap_error[k]];
  if (Number.isNaN(work)) return "";
  const time = Number.isNaN(snap) ? "" : `, the time of snap by ${Number(snap.toPrecision(2))} µs`;
  return ` With another step, which indicates the error, the work of the pulse differs by ${Number((100 * work).toPrecision(2))} %${time}.`;
}

function left(energy) {
  if (Number.isNaN(energy)) return "the trace of it broke off";
  const least = energy >= study.reach ? "at least " : "";
  return `at the end of this history the energy is ${least}${round(energy)} times the saddle's`;
}

function drawDevice() {
  const chosen = Object.fromEntries(axes.map(({ name, texts }, n) => [name, texts[at[n]]]));
  const written = study.devices[chosen.device ?? ""] ?? [];
  const further = study.varied.filter(([key]) => !written.some(([own]) => own === key));
  const rows = [...written, ...further].map(([key, words, text]) =>
    `<tr><th scope="row">${words}</th><td>${chosen[key] ?? text}</td></tr>`);
  document.getElementById("device").innerHTML = `The device ${chosen.device ?? ""}`;
  document.getElementById("values").innerHTML = rows.join("");
  document.getElementById("vibration").innerHTML = study.vibrations[chosen.device ?? ""].map(([name, ...cells]) =>
    `<tr><th scope="row">${name}</th>${cells.map((cell) => `<td>${cell}</td>`).join("")}</tr>`).join("");
}

function choose(i, j) {
  const within = (n, place) => Math.min(Math.max(place, 0), axes[n].values.length - 1);
  [at[X], at[Y]] = [within(X, i), within(Y, j)];
  Plotly.restyle(map, marksAt([[at[X], at[Y]]]), CHOSEN);
  drawHistory();
}

function addSlider({ name, label, values, texts }, n) {
  if (n === X || n === Y || values.length === 1) return;
  const id = `at-${name}`;
  const row = `<label for="${id}">${label}</label>
    <input id="${id}" type="range" min="0" max="${values.length - 1}" step="1" value="${at[n]}">
    <output for="${id}"></output>`;
  document.getElementById("sliders").insertAdjacentHTML("beforeend", row);
  const slider = document.getElementById(id);
  const show = () => {
    slider.nextElementSibling.innerHTML = texts[at[n]];
    slider.setAttribute("aria-valuetext", slider.nextElementSibling.textContent);
  };
  slider.addEventListener("input", () => {
    at[n] = Number(slider.value);
    show();
    drawMap();
    drawHistory();
  });
  show();
}

function addViews() {
  const row = document.getElementById("views");
  row.innerHTML = study.views.map(({ words }, n) =>
    `<label><input type="radio" name="view" value="${n}" ${n ? "" : "checked"}>${words}</label>`).join("");
  row.addEventListener("change", ({ target }) => {
    view = study.views[target.value];
    drawMap();
  });
}

function addSteps() {
  const row = document.getElementById("steps");
  row.innerHTML = STEPS.map(([n, keys]) => {
    const buttons = keys.map(([key, sign], up) => `<button type="button" value="${key}"
      aria-label="${up ? "next" : "previous"} ${axes[n].name}">${sign}</button>`);
    return `<span>${axes[n].lead.replace("=", "").trim() || axes[n].label}${buttons.join("")}</span>`;
  }).join("");
  row.addEventListener("click", ({ target }) => move(target.value));
}

function move(key) {
  if (!(key in MOVES)) return false;
  const [right, up] = MOVES[key];
  choose(at[X] + right, at[Y] + up);
  return true;
}

async function start() {
  await Promise.all(Object.entries(study.arrays).map(async ([key, packed]) => {
    cells[key] = await unpack(packed);
  }));
  await Promise.all([openMap(), study.bins && openMotion()]);
  addViews();
  axes.forEach(addSlider);
  addSteps();
  map.on("plotly_click", ({ points }) => choose(points[0].pointIndex[1], points[0].pointIndex[0]));
  document.getElementById("keys").addEventListener("keydown", (event) => {
    if (move(event.key)) event.preventDefault();
  });
  // A finger scrolls the page over a figure, and does not zoom in it.
  if (matchMedia("(pointer: coarse)").matches) {
    await Promise.all([...document.querySelectorAll(".js-plotly-plot")].map((figure) =>
      Plotly.relayout(figure, { dragmode: false })));
  }
  drawMap();
  choose(at[X], at[Y]);
}

start().catch((error) => {
  document.getElementById("verdict").textContent = `The page could not be drawn: ${error.message}`;
  throw error;
});

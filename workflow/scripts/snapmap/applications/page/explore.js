// Fills the page: the map over two axes at the sliders' places on all others, and the motion under the
// chosen shock, which `simulate.js` follows.

const study = JSON.parse(document.getElementById("data").textContent);
const { axes, at } = study; // at: place of the chosen shock on each axis, an integer at a cell
const [map, motion, room] = ["map", "history", "motion"].map((id) => document.getElementById(id));
const [X, Y, ...SHOCK] = [study.x, study.y, "N", "f0", "C"].map((key) => axes.findIndex(({ name }) => name === key));
const BETWEEN = 20; // steps of a slider from one cell to the next
const PLAYED = 6000, FRAME = 40; // ms
const strides = axes.map((_, n) => axes.slice(n + 1).reduce((cells, { values }) => cells * values.length, 1));
const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const CELLS = 0, ALWAYS = 1, FIRST = 2, CHOSEN = [3, 4], POINTS = 5; // curves of the map
const KINDS = { uint8: Uint8Array, float32: Float32Array, float64: Float64Array };
const ends = study.views.find(({ name }) => name === "end") ?? study.views[0]; // whose words describe a cell
let view = study.views[0]; // what the map shows
const cells = {}; // arrays over the cells; the thresholds' are over the rows of cells along N
let run = null; // the last result of `follow`
let turn = 0; // number of the choice that is followed

const PLAIN = {
  font: { family: "system-ui, sans-serif", size: 12, color: "#242424" },
  hoverlabel: { bgcolor: "white", align: "left" },
  hovermode: "closest",
  showlegend: false,
  modebar: { color: "#666666", activecolor: "#242424", bgcolor: "rgba(0, 0, 0, 0)" },
  margin: { l: 60, r: 12, t: 30, b: 50 },
};
const AXIS = { showline: true, linecolor: "#242424", ticks: "outside", showgrid: false, zeroline: false, automargin: true };
const BUTTONS = {
  responsive: true,
  displaylogo: false,
  doubleClick: "reset", // two quick clicks on different cells count as a double click, too
  modeBarButtons: [["toImage", "resetScale2d"]],
};
const [BAND, BEAM, TOTAL, AID] = ["rgba(0, 114, 178, 0.35)", "#0072b2", "#d55e00", "#555555"];
const REACH = 4; // the largest energy shown, over the saddle's

async function unpack({ kind, bytes }) {
  const packed = Uint8Array.from(atob(bytes), (sign) => sign.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new KINDS[kind](await new Response(stream).arrayBuffer());
}

const round = (value, digits = 4) => String(Number(value.toPrecision(digits)));
const state = (k) => ends.states[cells[ends.name][k]];
const isAbsent = (k) => state(k).name === "absent";
const nearest = () => at.map(Math.round);
const isCell = () => at.every(Number.isInteger);
const rowOf = (k) => Math.floor(k / axes.at(-1).values.length);
const place = (i, j) => nearest().reduce((k, rest, n) => k + (n === X ? i : n === Y ? j : rest) * strides[n], 0);

function scaleOf({ title, type, edges, ticks }) {
  const range = [edges[0], edges.at(-1)].map(type === "log" ? Math.log10 : Number);
  return { ...AXIS, ...ticks, title: { text: title }, type, range, tickangle: 0 };
}

// Opens the map without cells, colours and lines; drawMap adds them.
function openMap() {
  const bare = { type: "scatter", hoverinfo: "skip" };
  const ring = { symbol: "circle-open", size: 15, color: "black", line: { width: 2 } };
  const rings = [{ ...ring, color: "white", line: { width: 5 } }, ring];
  const along = { ...bare, mode: "lines+markers", x: axes[X].values };
  const curves = [
    { type: "heatmap", x: axes[X].edges, y: axes[Y].edges, zmin: -0.5, showscale: false, hoverinfo: "none" },
    { ...along, line: { color: "black", width: 1 }, marker: { symbol: "line-ew-open", size: 9, color: "black" } },
    { ...along, line: { color: "black", width: 1.5 }, marker: { size: 3, color: "black" }, error_y: { type: "data", thickness: 1, width: 3 } },
    ...rings.map((marker) => ({ ...bare, mode: "markers", marker })),
    { ...bare, mode: "markers", marker: { symbol: "diamond", size: 9, line: { width: 1.5, color: "black" } } },
  ];
  const layout = { ...PLAIN, xaxis: scaleOf(axes[X]), yaxis: scaleOf(axes[Y]) };
  if (study.durations) {
    curves.push({ ...bare, x: [null], y: [null], xaxis: "x2" }); // no axis is shown without a curve
    const title = { text: "pulse duration 1/f<sub>0</sub> (ms)", standoff: 4 };
    layout.xaxis2 = { ...layout.xaxis, ...study.durations, overlaying: "x", matches: "x", side: "top", title };
    layout.margin = { ...PLAIN.margin, t: 84 };
  }
  return Plotly.newPlot(map, curves, layout, BUTTONS);
}

// Opens the figure of positions and energies.
function openMotion() {
  const line = (name, color, width, more) => ({
    type: "scatter", mode: "lines", name, line: { color, width }, hovertemplate: "%{y:.3g} at %{x:.3g} ms", ...more,
  });
  const curves = [
    line("w(L/2), least", BEAM, 0.7),
    line("midpoint w(L/2)", BEAM, 0.7, { fill: "tonexty", fillcolor: BAND }),
    line("mass z<sub>M</sub>", "#000000", 1.5),
    line("energy", TOTAL, 1.5, { yaxis: "y2" }),
    line("beam's energy", BEAM, 1, { yaxis: "y2" }),
  ];
  const mark = (name, dash, where) => ({ type: "line", name, line: { color: AID, width: 1.2, dash }, x0: 0, y0: 0, y1: 1, ...where });
  const level = { xref: "x domain", x1: 1 }, instant = { yref: "paper", x1: 0 };
  const shapes = [
    mark("second shape w<sub>2</sub>", "8 4", level),
    mark("saddle", "none", { ...level, yref: "y2", y0: 1 }),
    ...[["end of the pulse", "2 2"], ["snap", "8 3 2 3"], ["settled", "12 4"]].map(([name, dash]) => mark(name, dash, instant)),
  ];
  const stroke = ({ color, width, dash }) => `<path d="M0 6H28" stroke="${color}" stroke-width="${width}" stroke-dasharray="${dash ?? "none"}"/>`;
  // This list wraps on a phone; plotly's legend does not.
  document.getElementById("lines").innerHTML = [...curves.slice(1), ...shapes].map(({ name, line: look, fill }) =>
    `<li><svg width="28" height="12" aria-hidden="true">${stroke(look)}${fill ? stroke({ color: BAND, width: 9 }) : ""}</svg> ${name}</li>`).join("");
  const upright = (text, domain) => ({ ...AXIS, title: { text }, domain });
  return Plotly.newPlot(motion, curves, {
    ...PLAIN,
    shapes,
    xaxis: { ...AXIS, title: { text: "time after the start of the pulse (ms)" }, anchor: "y2" },
    yaxis: upright("position (µm)", [0.45, 1]),
    yaxis2: upright("energy / saddle's", [0, 0.4]),
  }, BUTTONS);
}

function byCell(make) {
  return axes[Y].values.map((_, j) => axes[X].values.map((_, i) => make(place(i, j))));
}

function describe(i, j) {
  const k = place(i, j), where = [[Y, j], [X, i]].map(([n, value]) => axes[n].lead + axes[n].texts[value]);
  const snap = Number.isNaN(cells.t_snap[k]) ? [] : [`snaps at t = ${round(cells.t_snap[k])} µs`];
  return [`<b>${state(k).words}</b>`, ...where, ...snap].join("; ");
}

function drawMap() {
  const z = byCell((k) => cells[view.name][k]), codes = z.flat();
  Plotly.restyle(map, { z: [z], colorscale: [view.scale], zmax: view.states.length - 0.5 }, [CELLS]);
  const hasLines = axes[Y].name === "N" && view.name === "snap";
  const [N, error, always] = ["N_first", "N_error", "N_always"].map((key) =>
    axes[X].values.map((_, i) => (hasLines ? cells[key][rowOf(place(i, 0))] : NaN)));
  const known = error.map((bar) => (Number.isFinite(bar) ? bar : 0));
  const above = always.map((all, i) => (all > N[i] + known[i] ? all : NaN));
  Plotly.restyle(map, { y: [above, N], "error_y.array": [null, known] }, [ALWAYS, FIRST]);
  const counts = view.states.map((_, code) => codes.filter((other) => other === code).length);
  const items = view.states.map(({ key }, code) => (counts[code] ? `${key} (${counts[code]})` : ""));
  if (N.some(Number.isFinite)) items.push('<i class="line"></i>lowest N that snaps, with its error');
  if (above.some(Number.isFinite)) items.push('<i class="line always"></i>N above which all snap');
  document.getElementById("classes").innerHTML = items.filter(Boolean).concat(drawMarks()).map((item) => `<li>${item}</li>`).join("");
}

// Draws the numbers of required shocks of the chosen pulse, and own points; returns the keys of both.
function drawMarks() {
  const { shape, direction } = pulseAt();
  const shown = study.required.filter(({ pushed }) => pushed.some(([kind, way]) => kind === shape && way === direction));
  const look = { bgcolor: "white", bordercolor: "black", font: { size: 11, color: "black" }, arrowwidth: 1 };
  Plotly.relayout(map, { annotations: shown.map(({ mark }) => ({ ...look, ...mark })) });
  const { f0, N, face, keys } = study.points;
  Plotly.restyle(map, { x: [f0], y: [N], "marker.color": [face] }, [POINTS]);
  return [...shown.map(({ words }) => words), ...keys];
}

// Interpolates between the values of an axis, at a place between two cells.
function between(values, place, isLog) {
  const low = Math.floor(place), [a, b] = [values[low], values[Math.ceil(place)]];
  if (a === b) return a;
  return isLog ? a * (b / a) ** (place - low) : a + (b - a) * (place - low);
}

const valueOf = (n, key = "numbers") => between(axes[n][key], at[n], axes[n].type === "log");
const textOf = (n) => (Number.isInteger(at[n]) ? axes[n].texts[at[n]] : `${round(valueOf(n))}\u00a0${axes[n].unit}`.trim());

function drawChoice() {
  const k = place(Math.round(at[X]), Math.round(at[Y]));
  Plotly.restyle(map, { x: [[valueOf(X, "values")]], y: [[valueOf(Y, "values")]] }, CHOSEN);
  const values = axes.map(({ lead }, n) => `<span>${lead}${textOf(n)}</span>`);
  document.getElementById("cell").innerHTML = values.reverse().join(", ");
  document.getElementById("edge").textContent = isAbsent(k) || !isCell() ? "" : threshold(rowOf(k));
  document.getElementById("verdict").innerHTML = isCell()
    ? `<b>${state(k).words}:</b> ${verdict(k)}.` : "<b>between cells:</b> the map has no run of this shock, only the page has, below.";
  document.querySelectorAll(".sliders input").forEach((slider) => slider.show());
  drawDevice();
  followChoice(k);
}

const pulseAt = () => study.pulses[axes.reduce((number, { name, values }, n) =>
  (["shape", "direction"].includes(name) ? number * values.length + nearest()[n] : number), 0)];

function formAt() {
  const ofDevice = axes.filter(({ name }) => !["shape", "direction", "N", "f0", "C"].includes(name)).length;
  const device = axes.slice(0, ofDevice).reduce((number, { values }, n) => number * values.length + nearest()[n], 0);
  const row = study.deviceOf[device] * study.width;
  return formOf(study.places, cells.forms.subarray(row, row + study.width));
}

// The shortest step of the cells around the chosen shock, us.
function stepAt() {
  const around = at.reduce((corners, where, n) => corners.flatMap((k) => [Math.floor, Math.ceil].map((to) => k + to(where) * strides[n])), [0]);
  return Math.min(...around.map((k) => cells.dt[k]));
}

// Follows the chosen shock, bit by bit, until another is chosen: to the horizon, or somewhat beyond where its cell settled.
async function followChoice(k) {
  const choice = (turn += 1), line = document.getElementById("followed"), pulse = pulseAt();
  run = null;
  room.hidden = isAbsent(k) || !pulse.pieces;
  if (room.hidden) line.textContent = isAbsent(k) ? "" : study.unfollowed;
  if (room.hidden) return;
  const [N, f0, C] = SHOCK.map((n) => valueOf(n)), form = formAt(), lasts = 1e6 / f0;
  const [snap, settled] = isCell() ? [cells.t_snap[k], cells.t_settled[k]] : [NaN, NaN];
  const end = Math.min(lasts + study.horizon, Number.isNaN(settled) ? Infinity : 1.2 * settled);
  const course = follow(form, pulse, { N, f0: f0 * 1e-6, C }, end, stepAt());
  for (;;) {
    await new Promise((go) => { setTimeout(go); });
    if (choice !== turn) return;
    const { done, value } = course.next();
    if (!done) continue;
    run = { ...value, form };
    drawRun([lasts, isCell() ? snap : run.snap, settled]);
    const isOther = isCell() && endsOtherwise(k);
    drawScene(isOther ? 0 : 1);
    line.innerHTML = followed(isOther);
    return;
  }
}

function drawRun(instants) {
  const { form, bins, dt, every } = run, unit = form.BARRIER || 1, z0 = form.first + form.Z0;
  const column = (make) => bins.map(make), starts = column((_, bin) => (bin * every * dt) / 1e3);
  const middles = starts.map((start) => start + (every * dt) / 2e3);
  run.w = column(({ low, high }) => form.first + (low + high) / 2);
  run.z = Number.isFinite(z0) ? column(({ y }) => z0 + y) : [];
  const energy = column((bin) => bin.energy / unit), most = energy.reduce((top, value) => Math.max(top, value), 1.2);
  const curves = {
    x: [middles, middles, starts, starts, starts],
    y: [column(({ low }) => form.first + low), column(({ high }) => form.first + high), run.z, energy, column(({ beam }) => beam / unit)],
  };
  const keys = [...document.getElementById("lines").children];
  keys.slice(-3).forEach((key, n) => { key.hidden = Number.isNaN(instants[n]); });
  keys[1].hidden = !run.z.length;
  const [second, saddle, ...marks] = motion.layout.shapes;
  const moved = marks.map((mark, n) => ({ ...mark, visible: !Number.isNaN(instants[n]), x0: instants[n] / 1e3, x1: instants[n] / 1e3 }));
  const shapes = [{ ...second, y0: form.second, y1: form.second }, saddle, ...moved];
  const whole = { "xaxis.autorange": true, "yaxis.autorange": true, "yaxis2.range": [0, Math.min(REACH, 1.05 * most)] };
  Plotly.update(motion, curves, { shapes, ...whole });
  Plotly.Plots.resize(motion); // the window may have changed while it was hidden
}

// Whether the page's own run ends otherwise than that of its cell.
function endsOtherwise(k) {
  const isKnown = cells.well[k] && state(k).name !== "elsewhere";
  const isAcross = isKnown && (cells.well[k] === 2) !== run.isAcross;
  return state(k).name !== "failed" && (isAcross || Number.isNaN(run.snap) !== Number.isNaN(cells.t_snap[k]));
}

// Says what is drawn; at a cell without times, as the verdict has those of the map's run.
function followed(isOther) {
  if (run.failed) return "The page's own run of this shock diverged.";
  const drawn = `Drawn below is the page's own, simpler run of this shock, in ${run.steps} steps of ${round(run.dt)} µs`;
  if (isCell() && !isOther) return `${drawn}. It snaps a little earlier or later than the map's run.`;
  const at = isOther || Number.isNaN(run.snap) ? "" : ` at t = ${round(run.snap)} µs`;
  const snaps = Number.isNaN(run.snap) ? "it does not snap" : `it snaps${at}`;
  const ends = `${snaps}, and is last seen on the side of the ${study.shapes[Number(run.isAcross)]} shape`;
  return isOther ? `<b>${drawn}. It ends otherwise: ${ends}. The map's run counts.</b>` : `${drawn}: ${ends}.`;
}

// Draws beam and mass at a share of the time shown; the beam is a cosine with the midpoint's height.
function drawScene(share) {
  if (!run) return;
  const bin = Math.min(Math.floor(share * run.w.length), run.w.length - 1);
  const { form } = run, height = 35 / Math.max(Math.abs(form.first), Math.abs(form.second), 1e-9);
  const up = (place) => 55 - Math.max(-50, Math.min(height * place, 50));
  const beam = (w) => `M${Array.from({ length: 41 }, (_, n) =>
    `${7.5 * n} ${up((w * (1 - Math.cos((Math.PI * n) / 20))) / 2)}`).join("L")}`;
  document.getElementById("beam").setAttribute("d", beam(run.w[bin]));
  document.getElementById("other").setAttribute("d", beam(form.SIDE > 0 ? form.second : form.first));
  const mass = run.z.length ? `M150 ${up(run.z[bin]) - 2}l-6 -9h-24v-9h60v9h-24Z` : "";
  document.getElementById("mass").setAttribute("d", mass);
  document.getElementById("instant").value = share;
  document.getElementById("now").textContent = `${round((bin * run.every * run.dt) / 1e3)}\u00a0ms`;
}

function addPlayer() {
  const [button, slider] = ["play", "instant"].map((id) => document.getElementById(id));
  let clock = null;
  const stop = () => {
    clock = clearInterval(clock);
    button.textContent = "play";
  };
  button.addEventListener("click", () => {
    if (clock) return stop();
    let share = 0;
    button.textContent = "stop";
    clock = setInterval(() => {
      drawScene(share = Math.min(share + FRAME / PLAYED, 1));
      if (share === 1) stop();
    }, FRAME);
  });
  slider.addEventListener("input", () => {
    stop();
    drawScene(Number(slider.value));
  });
}

function threshold(row) {
  const [N, error, always] = [cells.N_first[row], cells.N_error[row], cells.N_always[row]];
  if (Number.isNaN(N)) return "Here nothing snaps at any N looked at.";
  const bar = Number.isFinite(error) ? `\u00a0±\u00a0${round(error, 2)}` : "";
  const all = always > N ? `; above ${round(always, 5)} all snap` : "";
  return `Here the lowest N that snaps is ${round(N, 5)}${bar}${all}.`;
}

// Tells what the map's run of a cell saw: its snap, its end, and its estimated errors.
function verdict(k) {
  if (isAbsent(k)) return "the beam of this device springs back wherever it is pushed; nothing was simulated";
  if (state(k).name === "failed") return "the run diverged, or its energy did not add up; nothing is known of this cell";
  const [snapped, settled, well, work, snap] = ["t_snap", "t_settled", "well", "work_error", "t_snap_error"].map((key) => cells[key][k]);
  const side = study.shapes[well - 1], share = Math.floor(100 * cells.share[k]);
  const end = well ? `it has not settled, but was on the side of the ${side} shape for ${share} % of the last vibration of the mass` : "what follows was not simulated";
  const told = [
    Number.isNaN(snapped) ? `no snap within ${round(study.horizon / 1e3)} ms after the pulse` : `the midpoint reaches the ${study.shapes[1]} shape at t = ${round(snapped)} µs`,
    Number.isNaN(settled) ? end : `settles in the ${side} shape at t = ${round(settled)} µs, as its energy is then too low to leave`,
  ];
  if (!Number.isNaN(work)) told.push(`estimated error, from a second run in other time steps: ${round(100 * work, 2)} % of the work of the pulse`);
  if (!Number.isNaN(snap)) told.push(`${round(snap, 2)} µs of the time of the snap`);
  return told.join("; ");
}

function drawDevice() {
  const chosen = Object.fromEntries(axes.map(({ name, texts }, n) => [name, texts[nearest()[n]]]));
  const written = study.devices[chosen.device ?? ""] ?? [];
  const further = study.varied.filter(([key]) => !written.some(([name]) => name === key));
  const rows = [...written, ...further].map(([key, words, text]) => `<tr><th scope="row">${words}</th><td>${chosen[key] ?? text}</td></tr>`);
  document.getElementById("device").innerHTML = `The device ${chosen.device ?? ""}`;
  document.getElementById("values").innerHTML = rows.join("");
}

function choose(i, j) {
  const within = (n, place) => Math.min(Math.max(place, 0), axes[n].values.length - 1);
  Object.assign(at, nearest());
  [at[X], at[Y]] = [within(X, i), within(Y, j)];
  drawChoice();
}

// Sliders of the shock also stop between cells.
function addSlider(n) {
  const { name, label, values } = axes[n];
  const [id, isOfShock] = [`at-${name}`, SHOCK.includes(n)];
  if (values.length === 1 || (!isOfShock && (n === X || n === Y))) return;
  const row = `<label for="${id}">${label}</label>
    <input id="${id}" type="range" min="0" max="${values.length - 1}" step="${isOfShock ? 1 / BETWEEN : 1}" value="${at[n]}">
    <output for="${id}"></output>`;
  document.getElementById(isOfShock ? "shock" : "sliders").insertAdjacentHTML("beforeend", row);
  const slider = document.getElementById(id);
  slider.show = () => {
    slider.value = at[n];
    slider.nextElementSibling.innerHTML = textOf(n);
    slider.setAttribute("aria-valuetext", slider.nextElementSibling.textContent);
  };
  slider.addEventListener("input", () => {
    const before = Math.round(at[n]);
    at[n] = Number(slider.value);
    if (n !== X && n !== Y && Math.round(at[n]) !== before) drawMap();
    drawChoice();
  });
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

async function start() {
  const library = document.createElement("script");
  library.textContent = new TextDecoder().decode(await unpack(study.plotly));
  document.head.append(library);
  await Promise.all(Object.entries(study.arrays).map(async ([key, packed]) => { cells[key] = await unpack(packed); }));
  await Promise.all(study.pulses.map(async (pulse) => { pulse.pieces = pulse.pieces && await unpack(pulse.pieces); }));
  await Promise.all([openMap(), openMotion()]);
  addViews();
  [...axes.keys()].filter((n) => !SHOCK.includes(n)).concat(SHOCK).forEach(addSlider);
  addPlayer();
  const hovered = document.getElementById("hovered");
  map.on("plotly_hover", ({ points: [{ pointIndex: [j, i] }] }) => { hovered.innerHTML = describe(i, j); });
  map.on("plotly_unhover", () => { hovered.textContent = ""; });
  map.on("plotly_click", ({ points }) => choose(points[0].pointIndex[1], points[0].pointIndex[0]));
  document.getElementById("keys").addEventListener("keydown", (event) => {
    if (!(event.key in MOVES)) return;
    event.preventDefault();
    choose(...MOVES[event.key].map((step, n) => Math.round(at[[X, Y][n]]) + step));
  });
  // A finger scrolls the page over a figure, and does not zoom in it.
  if (matchMedia("(pointer: coarse)").matches) {
    await Promise.all([map, motion].map((figure) => Plotly.relayout(figure, { dragmode: false })));
  }
  drawMap();
  choose(at[X], at[Y]);
}

start().catch((error) => {
  document.getElementById("verdict").textContent = `The page could not be drawn: ${error.message}`;
  throw error;
});

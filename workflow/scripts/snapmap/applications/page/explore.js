// Fills the page: the map over two axes at the sliders' places on all others, and the motion under the
// chosen shock, which `simulate.js` follows.

const study = JSON.parse(document.getElementById("data").textContent);
const { axes } = study;
const [map, motion, room] = ["map", "history", "motion"].map((id) => document.getElementById(id));
const [X, Y, ...SHOCK] = [study.x, study.y, "N", "f0", "C"].map((key) => axes.findIndex(({ name }) => name === key));
const PULSE = SHOCK[1], BETWEEN = 20; // steps of a slider from one cell to the next
const PLAYED = 6000; // ms
const strides = axes.map((_, n) => axes.slice(n + 1).reduce((cells, { values }) => cells * values.length, 1));
const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const STEPS = [[X, [["ArrowLeft", "←"], ["ArrowRight", "→"]]], [Y, [["ArrowDown", "↓"], ["ArrowUp", "↑"]]]];
const LINES = [1, 2, 3], CHOSEN = [4, 5], REQUIRED = 6; // curves of the map, after the cells
const SNAPPED = study.views[0].states.findIndex(({ name }) => name === "snapped");
const KINDS = { uint8: Uint8Array, float32: Float32Array, float64: Float64Array };
const ends = study.views.find(({ name }) => name === "end") ?? study.views[0]; // whose words describe a cell
let view = study.views[0]; // what the map shows
const cells = {}; // arrays over the cells; the thresholds' are over the rows of cells along N
const at = study.start; // place of the chosen shock on each axis, an integer at a cell
let run = null; // the last result of `follow`
let forms = null;

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
  showSendToCloud: false, // a button that uploads the study
  plotlyServerURL: "",
  doubleClick: "reset", // two quick clicks on different cells count as a double click, too
  modeBarButtonsToRemove: ["select", "lasso", "autoScale"],
};
const [BAND, BEAM, TOTAL, AID] = ["rgba(0, 114, 178, 0.35)", "#0072b2", "#d55e00", "#555555"];
const DASHES = { dash: "8 4", dot: "2 2", dashdot: "8 3 2 3", longdash: "12 4" }; // plotly's dashes in SVG
const REACH = 4; // the largest energy shown, over the saddle's
const TICKS = 5; // at most; more would overlap on a phone

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
const nearest = () => at.map(Math.round);
const isCell = () => at.every(Number.isInteger);
const rowOf = (k) => Math.floor(k / axes.at(-1).values.length);

// Round ticks: 1, 2 and 5 of each decade, or fewer; evenly spaced between close ends.
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
  return { ...scale, tickangle: 0, tickvals: ticks, ticktext: ticks.map(round) };
}

// The axis of durations (ms) above that of frequencies (Hz).
function durations({ values, edges }) {
  const ticks = values.length > 1 ? roundBetween(1e3 / edges.at(-1), 1e3 / edges[0]) : [1e3 / values[0]];
  const title = { text: "pulse duration 1/f<sub>0</sub> (ms)", standoff: 4 };
  const above = { overlaying: "x", matches: "x", side: "top", title };
  return { ...above, tickvals: ticks.map((tick) => 1e3 / tick), ticktext: ticks.map(round) };
}

// Opens the map without cells, colours and lines; drawMap adds them.
function openMap() {
  const bare = { type: "scatter", hoverinfo: "skip" };
  const pale = "rgba(255, 255, 255, 0.6)";
  const ring = { symbol: "circle-open", size: 15, color: "black", line: { width: 2 } };
  const marks = [{ ...ring, color: "white", line: { width: 5 } }, ring];
  const always = { symbol: "line-ew-open", size: 9, color: "black" };
  const curves = [
    { type: "heatmap", x: axes[X].edges, y: axes[Y].edges, zmin: -0.5, showscale: false, hoverinfo: "none" },
    // LINES: the N above which all snap; the error band of the lowest N that snaps; and that N.
    { ...bare, mode: "lines+markers", line: { color: "black", width: 1 }, marker: always },
    { ...bare, mode: "lines", line: { color: pale, width: 3 }, fill: "toself", fillcolor: pale },
    { ...bare, mode: "lines+markers", line: { color: "black", width: 1.5 }, marker: { size: 3, color: "black" } },
    ...marks.map((marker) => ({ ...bare, mode: "markers", marker })),
    { ...bare, mode: "markers+text", cliponaxis: false, textfont: { size: 11, color: "black" }, marker: { size: 17, color: "white", line: { width: 1, color: "black" } } },
  ];
  const layout = { ...PLAIN, xaxis: scaleOf(axes[X]), yaxis: scaleOf(axes[Y]) };
  if (X === PULSE) {
    curves.push({ ...bare, x: [null], y: [null], xaxis: "x2" }); // no axis is shown without a curve
    layout.xaxis2 = { ...layout.xaxis, ...durations(axes[X]) };
    layout.margin = { ...PLAIN.margin, t: 84 };
  }
  return Plotly.newPlot(map, curves, layout, BUTTONS);
}

// Opens the figure of positions and energies.
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
  const level = { xref: "x domain", x0: 0, x1: 1 };
  const instant = { xref: "x", x0: 0, x1: 0, yref: "paper", y0: 0, y1: 1 };
  const shapes = [
    mark("second shape w<sub>2</sub>", "dash", { ...level, yref: "y", y0: 0, y1: 0 }),
    mark("saddle", "solid", { ...level, yref: "y2", y0: 1, y1: 1 }),
    mark("end of the pulse", "dot", instant),
    mark("snap", "dashdot", instant),
    mark("settled", "longdash", instant),
  ];
  const stroke = ({ color, width, dash }) =>
    `<path d="M0 6H28" stroke="${color}" stroke-width="${width}" stroke-dasharray="${DASHES[dash] ?? "none"}"/>`;
  // This list wraps on a phone; plotly's legend does not.
  document.getElementById("lines").innerHTML = [...curves.slice(1), ...shapes].map(({ name, line: look, fill }) =>
    `<li><svg width="28" height="12" fill="none" aria-hidden="true">${stroke(look)}${
      fill ? stroke({ color: BAND, width: 9 }) : ""}</svg> ${name}</li>`).join("");
  const upright = (text, domain) => ({ ...AXIS, title: { text }, domain });
  return Plotly.newPlot(motion, curves, {
    ...PLAIN,
    shapes,
    xaxis: { ...AXIS, title: { text: "time after the start of the pulse (ms)" }, anchor: "y2" },
    yaxis: upright("position (µm)", [0.45, 1]),
    yaxis2: upright("energy / saddle's", [0, 0.4]),
  }, BUTTONS);
}

function place(i, j) {
  return nearest().reduce((k, rest, n) => k + (n === X ? i : n === Y ? j : rest) * strides[n], 0);
}

function byCell(make) {
  const corner = place(0, 0);
  return axes[Y].values.map((_, j) =>
    axes[X].values.map((_, i) => make(corner + i * strides[X] + j * strides[Y], i, j)));
}

function describe(i, j) {
  const k = place(i, j);
  const snap = cells.t_snap[k];
  const lines = [`<b>${state(k).words}</b>`, ...ending(k), say(Y, j), say(X, i)];
  if (isAbsent(k)) return lines.join("; ");
  return [...lines, Number.isNaN(snap) ? "no snap" : `snaps at t = ${round(snap)} µs`].join("; ");
}

// Lines about the end of a cell that its colour does not tell.
function ending(k) {
  const { words } = outcome(k);
  if (words === state(k).words) return [];
  if (!isOpen(k)) return [words];
  return cells.well[k] ? [words, ...side(k)] : [];
}

function side(k) {
  const well = ["", "first", "second"][cells.well[k]];
  const share = cells.share[k] < study.whole ? `during ${Math.floor(100 * cells.share[k])} %` : "for the whole";
  return [`on the ${well} side ${share}`, "of the last swing"];
}

function drawMap() {
  const codes = byCell((k) => cells[view.code][k]);
  const hasLines = axes[Y].name === "N" && view.name === "snap";
  const lines = hasLines ? thresholds() : LINES.map(() => ({ x: [], y: [] }));
  listClasses(codes.flat(), lines.map(({ y }) => y.some(Number.isFinite)));
  const layers = { x: lines.map(({ x }) => x), y: lines.map(({ y }) => y) };
  Plotly.restyle(map, layers, LINES);
  const colours = { colorscale: [view.scale], zmax: view.states.length - 0.5 };
  const z = byCell((k) => cells[view.code][k] + (view.ramp && cells.snap[k] === SNAPPED ? shade(k) : 0));
  Plotly.restyle(map, { z: [z], ...colours }, [0]);
  drawRequired();
}

// Draws the numbers of required shocks of the chosen pulse, at the map's edge if they lie beyond it.
function drawRequired() {
  const has = axes[X].name === "f0" && axes[Y].name === "N" && !axes[X].ticked && !axes[Y].ticked;
  const { shape, direction } = pulseAt();
  const shown = study.required.flatMap(([name, f0, N, pushed, verdict], n) =>
    (has && pushed.some(([kind, way]) => kind === shape && way === direction) ? [{ name, f0, N, verdict, text: String(n + 1) }] : []));
  const within = (n, value) => Math.min(Math.max(value, axes[n].edges[0]), axes[n].edges.at(-1));
  const [x, y] = [shown.map(({ f0 }) => within(X, f0)), shown.map(({ N }) => within(Y, N))];
  Plotly.restyle(map, { x: [x], y: [y], text: [shown.map(({ text }) => text)] }, [REQUIRED]);
  const row = document.getElementById("classes");
  row.insertAdjacentHTML("beforeend", shown.map(({ name, f0, N, verdict, text }, n) => {
    const beyond = x[n] === f0 && y[n] === N ? "" : " (beyond the map)";
    return `<li>${text}: required shock ${name}, N = ${round(N)}, ${round(f0)} Hz${beyond}${verdict && `; ${verdict}`}</li>`;
  }).join(""));
}

// Place of a cell's snap on the ramp of times, from -0.49 to 0.49.
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

// Lines along the map's x: N_always where it differs, the error band of N_first, and N_first.
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

// Interpolates between the values of an axis, at a place between two cells.
function between(values, place, isLog) {
  const low = Math.floor(place), [a, b] = [values[low], values[Math.ceil(place)]];
  if (a === b) return a;
  return isLog ? a * (b / a) ** (place - low) : a + (b - a) * (place - low);
}

const valueOf = (n) => between(axes[n].numbers, at[n], axes[n].type === "log");
const textOf = (n) => (Number.isInteger(at[n]) ? axes[n].texts[at[n]] : `${round(valueOf(n))}\u00a0${axes[n].unit}`.trim());

function marksAt(places) {
  const along = (n, place) => between(axes[n].values, place, axes[n].type === "log");
  return { x: [places.map(([i]) => along(X, i))], y: [places.map(([, j]) => along(Y, j))] };
}

function listClasses(codes, [hasAlways, , hasFirst]) {
  const items = view.states.map(({ words, colour }, code) => {
    const count = codes.filter((other) => other === code).length;
    const key = view.ramp && code === SNAPPED ? timeKey() : `<i style="background:${colour}"></i>${words}`;
    return count ? `<li>${key} (${count})</li>` : "";
  });
  if (hasFirst) items.push('<li><i class="line"></i>lowest N that snaps, with its error</li>');
  if (hasAlways) items.push('<li><i class="line always"></i>N above which all snap</li>');
  document.getElementById("classes").innerHTML = items.join("");
}

function timeKey() {
  const [first, last] = snapTimes().map((time) => `${round(time / 1e3)} ms`);
  return `${first} <i class="ramp" style="background:linear-gradient(to right, ${view.ramp})"></i>${last}, first snap`;
}

function drawChoice() {
  const k = place(Math.round(at[X]), Math.round(at[Y]));
  Plotly.restyle(map, marksAt([[at[X], at[Y]]]), CHOSEN);
  const values = axes.map(({ lead }, n) => `<span>${lead}${textOf(n)}</span>`);
  document.getElementById("cell").innerHTML = values.reverse().join(", ");
  document.getElementById("edge").textContent = isAbsent(k) || !isCell() ? "" : threshold(rowOf(k));
  document.getElementById("verdict").innerHTML = isCell()
    ? `<b>${state(k).words}:</b> ${verdict(k)}` : "<b>between cells:</b> the map has no run of this shock, only the page has, below.";
  document.querySelectorAll(".sliders input").forEach((slider) => slider.show());
  drawDevice();
  followChoice(k);
}

const pulseAt = () => study.pulses[axes.reduce((number, { name, values }, n) =>
  (["shape", "direction"].includes(name) ? number * values.length + nearest()[n] : number), 0)];

const isFollowed = () => Boolean(pulseAt().pieces);

function formAt() {
  const ofDevice = axes.filter(({ name }) => !["shape", "direction", "N", "f0", "C"].includes(name)).length;
  const place = axes.slice(0, ofDevice).reduce((number, { values }, n) => number * values.length + nearest()[n], 0);
  const row = study.deviceOf[place] * study.width;
  return formOf(study.names, forms.subarray(row, row + study.width));
}

let turn = 0;

// Follows the chosen shock, bit by bit, until another one is chosen.
async function followChoice(k) {
  const choice = (turn += 1), line = document.getElementById("followed");
  run = null;
  room.hidden = isAbsent(k) || !isFollowed();
  if (room.hidden) line.textContent = isAbsent(k) ? "" : study.unfollowed;
  if (room.hidden) return;
  const [N, f0, C] = SHOCK.map(valueOf), shock = { N, f0: f0 * 1e-6, C }, [form, pulse] = [formAt(), pulseAt()];
  const dt = stepOf(form, pulse, shock, study.limits);
  const course = follow(form, pulse, shock, study.horizon, study.side, dt);
  for (;;) {
    await new Promise((go) => { setTimeout(go); });
    if (choice !== turn) return;
    const { done, value } = course.next();
    if (!done) continue;
    run = { ...value, form, end: 1e-3 / shock.f0 };
    drawRun();
    const isOther = isCell() && endsOtherwise(k);
    drawScene(isOther ? 0 : 1);
    line.innerHTML = followed(isOther);
    return;
  }
}

function drawRun() {
  const { form, dt, every, low, high, y, snap, settled, end } = run;
  const starts = low.map((_, bin) => (bin * every * dt) / 1e3), middles = starts.map((start) => start + (every * dt) / 2e3);
  const unit = form.barrier || 1, [w, z] = [form.first, form.first + form.z0];
  run.w = low.map((least, bin) => w + (least + high[bin]) / 2);
  run.z = Number.isFinite(z) ? y.map((place) => z + place) : [];
  const instants = [end, snap / 1e3, settled / 1e3];
  const keys = [...document.getElementById("lines").children];
  keys.slice(-3).forEach((key, n) => { key.hidden = Number.isNaN(instants[n]); });
  keys[1].hidden = !run.z.length;
  const [second, saddle, ...marks] = motion.layout.shapes;
  const moved = marks.map((mark, n) => ({ ...mark, ...standing(instants[n]) }));
  const energies = [run.energy, run.beam].map((values) => values.map((value) => value / unit));
  const curves = {
    x: [middles, middles, starts, starts, starts],
    y: [low.map((least) => w + least), high.map((most) => w + most), run.z, ...energies],
  };
  const most = energies[0].reduce((top, value) => Math.max(top, value), 1.2);
  const whole = { "xaxis.autorange": true, "yaxis.autorange": true, "yaxis2.range": [0, Math.min(REACH, 1.05 * most)] };
  Plotly.update(motion, curves, { shapes: [{ ...second, y0: form.second, y1: form.second }, saddle, ...moved], ...whole });
  Plotly.Plots.resize(motion); // the window may have changed while it was hidden
}

function standing(time) {
  return Number.isNaN(time) ? { visible: false } : { visible: true, x0: time, x1: time };
}

// Whether the page's own run ends otherwise than that of its cell.
function endsOtherwise(k) {
  const isKnown = cells.well[k] && state(k).name !== "elsewhere";
  const isAcross = isKnown && (cells.well[k] === 2) !== run.isAcross;
  return outcome(k).name !== "failed" && (isAcross || Number.isNaN(run.snap) !== Number.isNaN(cells.t_snap[k]));
}

// Says what is drawn; at a cell without times, as the verdict has those of the map's run.
function followed(isOther) {
  const { snap, settled, isAcross, failed, dt, steps } = run;
  if (failed) return "The page's own run of this shock blew up.";
  const drawn = `Drawn below is the page's own, simpler run of this shock, in ${steps} steps of ${round(dt)} µs`;
  if (isCell() && !isOther) return `${drawn}. Its times differ a little from those of the map's run.`;
  const at = (time) => (isOther ? "" : ` at t = ${round(time)} µs`);
  const shape = study.shapes[Number(isAcross)];
  const snaps = Number.isNaN(snap) ? "it does not snap" : `it snaps${at(snap)}`;
  const ends = Number.isNaN(settled) ? `is last seen on the side of the ${shape} shape` : `settles in the ${shape} shape${at(settled)}`;
  return isOther ? `<b>${drawn}. It ends otherwise: ${snaps}, and ${ends}. The map's run counts.</b>` : `${drawn}: ${snaps}, and ${ends}.`;
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
  document.getElementById("other").setAttribute("d", beam(study.side > 0 ? form.second : form.first));
  const mass = run.z.length ? `M150 ${up(run.z[bin]) - 2}l-6 -9h-24v-9h60v9h-24Z` : "";
  document.getElementById("mass").setAttribute("d", mass);
  document.getElementById("instant").value = share;
  document.getElementById("now").textContent = `${round((bin * run.every * run.dt) / 1e3)}\u00a0ms`;
}

function addPlayer() {
  const [button, slider] = ["play", "instant"].map((id) => document.getElementById(id));
  let began = null;
  const show = (now) => {
    if (began === null) return;
    const share = (now - began) / PLAYED;
    drawScene(Math.min(share, 1));
    if (share < 1) return requestAnimationFrame(show);
    stop();
  };
  const stop = () => {
    began = null;
    button.textContent = "play";
  };
  button.addEventListener("click", () => {
    if (began !== null) return stop();
    button.textContent = "stop";
    began = performance.now();
    requestAnimationFrame(show);
  });
  slider.addEventListener("input", () => {
    stop();
    drawScene(Number(slider.value));
  });
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
  const at = (time) => ` at t = ${round(time)} µs`;
  const snap = `the midpoint reaches the ${study.shapes[1]} shape${at(cells.t_snap[k])}`;
  const seen = cells.well[k] ? `; it has not settled, but was ${side(k).join(" ")}` : "; what follows was not simulated";
  const settled = (shape) => `this run settles in the ${study.shapes[shape]} shape${at(cells.t_settled[k])}: its energy is then too low to leave`;
  return {
    unsnapped: `no snap within ${round(study.horizon / 1e3)} ms after the pulse${seen}.`,
    never: `no snap; ${settled(0)}.`,
    snapped: `${snap}${seen}.`,
    latched: `${snap}; ${settled(1)}.`,
    returned: `${snap}; ${settled(0)}.`,
    failed: "the run blew up or its energy did not add up; nothing is claimed of this cell.",
  }[outcome(k).name] + withAnotherStep(k);
}

function withAnotherStep(k) {
  const [work, snap] = [cells.work_error[k], cells.t_snap_error[k]];
  if (Number.isNaN(work)) return "";
  const time = Number.isNaN(snap) ? "" : ` and ${Number(snap.toPrecision(2))} µs in the time of the snap`;
  return ` Estimated error, from a second run in other time steps: ${Number((100 * work).toPrecision(2))} % in the work of the pulse${time}.`;
}

function drawDevice() {
  const chosen = Object.fromEntries(axes.map(({ name, texts }, n) => [name, texts[nearest()[n]]]));
  const written = study.devices[chosen.device ?? ""] ?? [];
  const further = study.varied.filter(([key]) => !written.some(([name]) => name === key));
  const rows = [...written, ...further].map(([key, words, text]) =>
    `<tr><th scope="row">${words}</th><td>${chosen[key] ?? text}</td></tr>`);
  document.getElementById("device").innerHTML = `The device ${chosen.device ?? ""}`;
  document.getElementById("values").innerHTML = rows.join("");
  document.getElementById("vibration").innerHTML = study.vibrations[chosen.device ?? ""][nearest()[SHOCK[2]]].map(([name, ...cells]) =>
    `<tr><th scope="row">${name}</th>${cells.map((cell) => `<td>${cell}</td>`).join("")}</tr>`).join("");
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
  choose(Math.round(at[X]) + right, Math.round(at[Y]) + up);
  return true;
}

async function start() {
  await Promise.all(Object.entries(study.arrays).map(async ([key, packed]) => {
    cells[key] = await unpack(packed);
  }));
  forms = await unpack(study.forms);
  await Promise.all(study.pulses.map(async (pulse) => {
    pulse.pieces = pulse.pieces && await unpack(pulse.pieces);
  }));
  await Promise.all([openMap(), openMotion()]);
  addViews();
  [...axes.keys()].filter((n) => !SHOCK.includes(n)).concat(SHOCK).forEach(addSlider);
  addSteps();
  addPlayer();
  const hovered = document.getElementById("hovered");
  map.on("plotly_hover", ({ points: [{ pointIndex: [j, i] }] }) => { hovered.innerHTML = describe(i, j); });
  map.on("plotly_unhover", () => { hovered.textContent = ""; });
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

"use strict";
// Fills the page's two figures: the map over two axes at the sliders' places on all others, and the
// history of the chosen cell.

const study = JSON.parse(document.getElementById("data").textContent);
const { axes } = study;
const [map, motion, room] = ["map", "history", "motion"].map((id) => document.getElementById(id));
const [X, Y, PULSE] = [study.x, study.y, "f0"].map((key) => axes.findIndex(({ name }) => name === key));
const strides = axes.map((_, n) => axes.slice(n + 1).reduce((cells, { values }) => cells * values.length, 1));
const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const KINDS = { uint8: Uint8Array, float32: Float32Array };
const cells = {};
const at = study.start; // the chosen cell's place on each axis

async function unpack({ kind, bytes }) {
  const packed = Uint8Array.from(atob(bytes), (sign) => sign.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new KINDS[kind](await new Response(stream).arrayBuffer());
}

const round = (value) => String(Number(value.toPrecision(4)));
const say = (n, place) => axes[n].lead + axes[n].texts[place];
const outcome = (k) => study.outcomes[cells.outcome[k]];
const isAbsent = (k) => outcome(k).name === "absent";

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
  const lines = [`<b>${outcome(k).words}</b>`, say(Y, j), say(X, i)];
  if (isAbsent(k)) return lines.join("<br>");
  lines.push(Number.isNaN(snap) ? "no snap" : `t<sub>snap</sub> = ${round(snap)} µs`);
  return lines.concat(cells.reproduced[k] ? [] : ["not reproduced with another step"]).join("<br>");
}

function drawMap() {
  const codes = byCell((k) => cells.outcome[k]);
  const apart = byCell((k, i, j) => (cells.reproduced[k] ? [] : [[i, j]])).flat(2);
  listClasses(codes.flat(), apart.length);
  Plotly.restyle(map, marksAt(apart), [1]);
  Plotly.restyle(map, { z: [codes], text: [byCell(describe)] }, [0]);
}

function marksAt(places) {
  return { x: [places.map(([i]) => axes[X].values[i])], y: [places.map(([, j]) => axes[Y].values[j])] };
}

function listClasses(codes, apart) {
  const items = study.outcomes.map(({ words, colour }, code) => {
    const count = codes.filter((other) => other === code).length;
    return count ? `<li><i style="background:${colour}"></i>${words} (${count})</li>` : "";
  });
  if (apart) items.push(`<li><i class="apart"></i>not reproduced with another step (${apart})</li>`);
  document.getElementById("classes").innerHTML = items.join("");
}

function trace(name, k) {
  const [scale, offset] = study.packing[name];
  const codes = cells[name].subarray(k * study.bins, (k + 1) * study.bins);
  return Array.from(codes, (code) => (code === study.missing ? null : offset + scale * code));
}

function drawHistory() {
  const k = place(at[X], at[Y]);
  const values = axes.map((_, n) => `<span>${say(n, at[n])}</span>`);
  document.getElementById("cell").innerHTML = values.reverse().join(", ");
  document.getElementById("verdict").innerHTML = `<b>${outcome(k).words}:</b> ${verdict(k)}`;
  const wasHidden = room.hidden;
  room.hidden = isAbsent(k);
  if (room.hidden) return;
  const starts = Array.from({ length: study.bins }, (_, bin) => (bin * cells.bin_length[k]) / 1e3);
  const middles = starts.map((start) => start + cells.bin_length[k] / 2e3);
  const names = Object.keys(study.packing);
  const end = 1e6 / axes[PULSE].values[at[PULSE]];
  const instants = [end, cells.t_snap[k], cells.t_settled[k]].map((time) => time / 1e3);
  const [second, saddle, ...marks] = motion.layout.shapes;
  const moved = marks.map((mark, n) => ({ ...mark, ...standing(instants[n]) }));
  const curves = { x: [middles, middles, starts, starts, starts], y: names.map((name) => trace(name, k)) };
  const whole = { "xaxis.autorange": true, "yaxis.autorange": true, "yaxis2.autorange": true };
  const level = { ...second, y0: cells.second[k], y1: cells.second[k] };
  Plotly.update(motion, curves, { shapes: [level, saddle, ...moved], ...whole });
  if (wasHidden) Plotly.Plots.resize(motion); // the window may have changed meanwhile
}

function standing(time) {
  return Number.isNaN(time) ? { visible: false } : { visible: true, x0: time, x1: time };
}

function verdict(k) {
  if (isAbsent(k)) return "the beam of this device springs back wherever it is pushed; nothing was simulated.";
  const energy = trace("energy", k);
  const snap = `the midpoint reached the second equilibrium at t = ${round(cells.t_snap[k])} µs`;
  const proven = `proven at t = ${round(cells.t_settled[k])} µs`;
  const fell = "the energy fell below the saddle";
  const apart = "the beam's own energy fell below the saddle, and the mass swings too weakly to touch it again";
  // After the pulse the energy only falls: if it is above the saddle after the proof, so it was then.
  const parted = energy[Math.ceil(cells.t_settled[k] / cells.bin_length[k])] > 1;
  const same = cells.reproduced[k] ? "" : " A run with another time step had another outcome.";
  return {
    unsnapped: `none within ${study.horizon} µs after the pulse; what follows is open: ${left(energy)}.`,
    never: `${proven}: after the pulse nothing adds to the energy, and it is below the saddle.`,
    snapped: `${snap}; what follows is open: ${left(energy)}.`,
    latched: `${snap}; that it stays is ${proven}: ${parted ? apart : fell}.`,
    returned: `${snap}; that it is back in the first shape for ever is ${proven}: ${fell}.`,
    failed: "the run blew up or its energy ledger did not close; nothing is claimed of this cell.",
  }[outcome(k).name] + same;
}

function left(energy) {
  const [scale, offset] = study.packing.energy;
  const last = energy.at(-1);
  if (last === null) return "the trace of it broke off";
  const most = last === offset + scale * (study.missing - 1);
  return `at the end of this history the energy is ${most ? "at least " : ""}${round(last)} times the saddle's`;
}

function choose(i, j) {
  const within = (n, place) => Math.min(Math.max(place, 0), axes[n].values.length - 1);
  [at[X], at[Y]] = [within(X, i), within(Y, j)];
  Plotly.restyle(map, marksAt([[at[X], at[Y]]]), [2, 3]);
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

async function start() {
  await Promise.all(Object.entries(study.arrays).map(async ([key, packed]) => {
    cells[key] = await unpack(packed);
  }));
  axes.forEach(addSlider);
  map.on("plotly_click", ({ points }) => choose(points[0].pointIndex[1], points[0].pointIndex[0]));
  document.getElementById("keys").addEventListener("keydown", (event) => {
    if (!(event.key in MOVES)) return;
    event.preventDefault();
    const [right, up] = MOVES[event.key];
    choose(at[X] + right, at[Y] + up);
  });
  drawMap();
  choose(at[X], at[Y]);
}

start().catch((error) => {
  document.getElementById("verdict").textContent = `The page could not be drawn: ${error.message}`;
  throw error;
});

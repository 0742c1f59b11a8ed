"use strict";
// Fills the page's two figures: the map for the C of the slider, the history for the chosen cell.

const study = JSON.parse(document.getElementById("data").textContent);
const { C, f0, N } = study.axes;
const [map, motion, slider] = ["map", "history", "slider"].map((id) => document.getElementById(id));
const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const KINDS = { uint8: Uint8Array, float32: Float32Array };
const cells = {};
let chosen = [f0.length >> 1, N.length >> 1];

async function unpack({ kind, bytes }) {
  const packed = Uint8Array.from(atob(bytes), (sign) => sign.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new KINDS[kind](await new Response(stream).arrayBuffer());
}

const round = (value) => String(Number(value.toPrecision(4)));
const damping = (value) => `C = ${round(value)}\u00a0µN\u00a0µs/µm`;
const place = (i, j) => (Number(slider.value) * f0.length + i) * N.length + j;
const outcome = (k) => study.outcomes[cells.outcome[k]];
const byCell = (make) => N.map((_, j) => f0.map((_, i) => make(i, j)));

function describe(i, j) {
  const k = place(i, j);
  const snap = cells.t_snap[k];
  const lines = [
    `<b>${outcome(k).words}</b>`,
    `N = ${round(N[j])}`,
    `f<sub>0</sub> = ${round(f0[i])} Hz`,
    Number.isNaN(snap) ? "no snap" : `t<sub>snap</sub> = ${round(snap)} µs`,
  ];
  return lines.concat(cells.reproduced[k] ? [] : ["not reproduced with another step"]).join("<br>");
}

function drawMap() {
  const text = damping(C[slider.value]);
  document.getElementById("C").textContent = text;
  slider.setAttribute("aria-valuetext", text);
  const codes = byCell((i, j) => cells.outcome[place(i, j)]);
  const apart = byCell((i, j) => [i, j]).flat().filter(([i, j]) => !cells.reproduced[place(i, j)]);
  listClasses(codes.flat(), apart.length);
  Plotly.restyle(map, { x: [apart.map(([i]) => f0[i])], y: [apart.map(([, j]) => N[j])] }, [1]);
  Plotly.restyle(map, { z: [codes], text: [byCell(describe)] }, [0]);
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
  const [i, j] = chosen;
  const k = place(i, j);
  const starts = Array.from({ length: study.bins }, (_, bin) => (bin * cells.bin_length[k]) / 1e3);
  const middles = starts.map((start) => start + cells.bin_length[k] / 2e3);
  const names = Object.keys(study.packing);
  const instants = [1e6 / f0[i], cells.t_snap[k], cells.t_settled[k]].map((time) => time / 1e3);
  const [second, saddle, ...marks] = motion.layout.shapes;
  const moved = marks.map((mark, n) => ({ ...mark, ...standing(instants[n]) }));
  const curves = { x: [middles, middles, starts, starts, starts], y: names.map((name) => trace(name, k)) };
  const whole = { "xaxis.autorange": true, "yaxis.autorange": true, "yaxis2.autorange": true };
  Plotly.update(motion, curves, { shapes: [second, saddle, ...moved], ...whole });
  document.getElementById("cell").innerHTML =
    `N = ${round(N[j])}, f<sub>0</sub> = ${round(f0[i])} Hz, ${damping(C[slider.value])}`;
  document.getElementById("verdict").innerHTML = `<b>${outcome(k).words}:</b> ${verdict(k)}`;
}

function standing(time) {
  return Number.isNaN(time) ? { visible: false } : { visible: true, x0: time, x1: time };
}

function verdict(k) {
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
  chosen = [Math.min(Math.max(i, 0), f0.length - 1), Math.min(Math.max(j, 0), N.length - 1)];
  Plotly.restyle(map, { x: [[f0[chosen[0]]]], y: [[N[chosen[1]]]] }, [2, 3]);
  drawHistory();
}

async function start() {
  await Promise.all(Object.entries(study.arrays).map(async ([key, packed]) => {
    cells[key] = await unpack(packed);
  }));
  slider.max = C.length - 1;
  slider.disabled = C.length === 1;
  slider.addEventListener("input", () => { drawMap(); drawHistory(); });
  map.on("plotly_click", ({ points }) => choose(points[0].pointIndex[1], points[0].pointIndex[0]));
  document.getElementById("keys").addEventListener("keydown", (event) => {
    if (!(event.key in MOVES)) return;
    event.preventDefault();
    const [right, up] = MOVES[event.key];
    choose(chosen[0] + right, chosen[1] + up);
  });
  drawMap();
  choose(...chosen);
}

start().catch((error) => {
  document.getElementById("verdict").textContent = `The page could not be drawn: ${error.message}`;
  throw error;
});

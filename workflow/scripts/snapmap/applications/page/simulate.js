"use strict";
// Follows one shock: the step of docs/theory.md, "One step" and "Stops", from a row of the kernel's own
// table. Lengths are in um, masses in ng, times in us; in a run time is counted in steps, and forces are
// times dt^2.

const CHUNK = 20000, SAMPLES = 400, EXACT = 2;

// The row of a device: its numbers by the kernel's names, then the vectors.
function formOf(places, row) {
  const form = Object.fromEntries(Object.entries(places).map(([name, n]) => [name, row[n]]));
  let from = places.vectors;
  const take = (size) => row.subarray(from, (from += size));
  const k = form.modes;
  return { ...form, kappa: take(k), sq0: take(k), f: take(k), e: take(k), S: take(k * k), rest: take(k) };
}

const sine = (turns) => Math.sin(2 * Math.PI * turns);

// The pulse over its peak, by the number of the step; at a jump its mean over a step, as in
// solver/kernel/pulse.py.
function pulseOf({ pieces, ends: [begin, end] }, xStep) {
  let k = 0;
  return (n) => {
    const x = n * xStep, beyond = (x - 1) / xStep + 0.5;
    if (x >= 1) return beyond < 1 ? end * (1 - beyond) : 0;
    while (6 * (k + 1) < pieces.length && pieces[6 * (k + 1)] <= x) k += 1;
    const [from, value, slope, turns, lift, swing] = pieces.subarray(6 * k, 6 * k + 6);
    const s = x - from;
    const a = value + slope * s + 2 * lift * sine((turns * s) / 2) ** 2 + swing * sine(turns * s);
    return a - (n === 0 ? begin / 2 : 0) - (beyond > 0 ? end * beyond : 0);
  };
}

// The state of a beam at rest and its mass, with every mode scaled to mass 1, as solver/kernel/lanes.py
// loads a cell.
function load(form, C, dt) {
  const { modes, M } = form, square = dt * dt;
  const s = form.kappa.map((stiffness) => {
    const half = Math.min(Math.sqrt(stiffness) * dt, EXACT) / 2;
    return 1 / Math.sqrt((half / Math.tan(half)) ** 2 + (stiffness * square) / 4);
  });
  const scaled = (vector) => vector.map((value, i) => value * s[i]);
  const drag = ((form.held + form.factor * C) * dt) / 2, beamDrag = (form.ALPHA * dt) / 2;
  const mass = M + (form.K * square) / 4, b = 1 / (1 + beamDrag);
  const beam = {
    ...form, dt, RESIDUAL: form.RESIDUAL / square, K: form.K * square, k: form.CONTACT * square, AXIAL: form.AXIAL * square,
    b, B: 1 / (mass + drag), isHeld: false, keep: (mass - drag) / (mass + drag), beamKeep: (1 - beamDrag) * b,
    gamma: (b * form.AXIAL * square) / 2, kappa: form.kappa.map((stiffness, i) => stiffness * square * s[i] ** 2),
    sq0: scaled(form.sq0), f: scaled(form.f), e: scaled(form.e),
    S: form.S.map((element, ij) => s[Math.floor(ij / modes)] * s[ij % modes] * element),
    p: form.rest.map((value, i) => value / s[i]), d: new Float64Array(modes), u: new Float64Array(modes),
    free: new Float64Array(modes), a: 0, y: 0, dy: 0, q: 0, x: 0, w: 0, P: 0,
  };
  for (let i = 0; i < modes; i += 1) {
    let u = 2 * beam.sq0[i];
    for (let j = 0; j < modes; j += 1) u += beam.S[i * modes + j] * beam.p[j];
    beam.q += u * beam.p[i];
    beam.w += beam.e[i] * beam.p[i];
  }
  beam.x = beam.w - beam.Z0;
  return beam;
}

// Advances p and y from n to n + 1, and q and x half way, under the acceleration a dt^2; w and P
// become those at n.
function advance(beam, a) {
  if (beam.y < -beam.STOP_TOWARD && beam.dy < 0) strike(beam, -beam.STOP_TOWARD);
  if (beam.y > beam.STOP_AWAY && beam.dy > 0) strike(beam, beam.STOP_AWAY);
  beam.a = a;
  const { modes, p, d, u, free, e, f, S, sq0, kappa, b, gamma } = beam, m = beam.x;
  let uu = 0, eu = 0, ep = 0, ee = 0, ef = 0, ud = 0;
  for (let i = 0; i < modes; i += 1) {
    u[i] = sq0[i];
    for (let j = 0; j < modes; j += 1) u[i] += S[i * modes + j] * p[j];
    free[i] = beam.beamKeep * d[i] - b * (kappa[i] * p[i] + f[i] * a);
    [uu, eu, ep, ee] = [uu + u[i] * u[i], eu + e[i] * u[i], ep + e[i] * p[i], ee + e[i] * e[i]];
    [ef, ud] = [ef + e[i] * free[i], ud + u[i] * (d[i] + free[i])];
  }
  const t = 1 + gamma * uu, rho = beam.q + ud / 2, pulls = -beam.M * a - beam.K * beam.y;
  let B, dyFree, F, beta;
  const press = (response) => {
    [B, dyFree] = [response, beam.keep * beam.dy + response * pulls];
    beta = (b * ee + B) / 2 - (b * gamma * eu * eu) / (2 * t);
    F = ep - beam.y - beam.Z0 + (ef - dyFree) / 2 - (gamma * eu * rho) / t;
    beam.P = force(m, F, beta, beam.k / 2);
  };
  press(beam.isHeld ? 0 : beam.B);
  if (beam.isHeld && (pulls + beam.P) * beam.y < 0) {
    beam.isHeld = false;
    press(beam.B);
  }
  const r = (rho - (b * eu * beam.P) / 2) / t, pull = 2 * gamma * r;
  beam.w = ep - beam.RESIDUAL * beam.P;
  beam.x = F - beta * beam.P;
  beam.q = 2 * r - beam.q;
  for (let i = 0; i < modes; i += 1) {
    d[i] = free[i] - pull * u[i] - b * beam.P * e[i];
    p[i] += d[i];
  }
  beam.dy = dyFree + B * beam.P;
  beam.y += beam.dy;
}

// The contact force, by the root of x + beta P(x) = F in docs/theory.md; m: x of the step before.
function force(m, F, beta, halfK) {
  const h = halfK * beta;
  if (m <= 0 && F <= 0) return 0;
  if (m >= 0 && F >= h * m) return (halfK * (F + m)) / (1 + h);
  if (m > 0) return (F - (F + m - Math.sqrt((F - m) ** 2 + 4 * h * m * m)) / 2) / beta;
  return (F - (F + m + Math.sqrt((F - m) ** 2 - 4 * h * F * m)) / (2 + 2 * h)) / beta;
}

// Reflects the mass at a stop that it passed, without a gain of energy.
function strike(beam, stop) {
  const { M, K, k, a, RESTITUTION: restitution, dy: d } = beam, m = beam.y - d / 2;
  const overlap = (z) => Math.max(0, beam.x - (z - m));
  const rise = (from, to) => (K * (to - from) * (to + from) + k * (overlap(to) - overlap(from)) * (overlap(to) + overlap(from))) / 2
    + M * a * (to - from);
  const squared = d * d - (2 * rise(m, stop)) / M;
  if (squared <= 0 && (m - stop) * d < 0) return; // it turns before the stop
  const left = restitution ** 2 * Math.max(squared, 0);
  let place = stop - restitution * (m - stop), away = left - (2 * rise(stop, place)) / M;
  if (away < 0) [place, away, beam.isHeld] = [stop, 0, true];
  beam.dy = -Math.sign(d) * Math.sqrt(away);
  beam.x -= place - m;
  beam.y = place + beam.dy / 2;
}

// w(L/2) from rest and y half way through the last step, and the energies there, of the beam and of all, pJ.
function halfway({ modes, p, d, kappa, e, AXIAL, q, M, K, k, y, dy, x, RESIDUAL, dt }) {
  let beam = (AXIAL * q * q) / 4, w = -RESIDUAL * k * Math.max(0, x);
  for (let i = 0; i < modes; i += 1) {
    beam += (d[i] * d[i] + kappa[i] * p[i] * (p[i] - d[i])) / 2;
    w += e[i] * (p[i] - d[i] / 2);
  }
  const middle = y - dy / 2, others = (M * dy * dy + K * middle * middle + k * Math.max(0, x) ** 2) / 2;
  return { w, y: middle, beam: beam / dt ** 2, energy: (beam + others) / dt ** 2 };
}

// Follows a shock { N, f0 (1/us), C } until `end`, us. Yields every CHUNK steps, so that the page can
// respond. A bin of `every` steps holds the extremes of w, and other values at its first step; w and y
// count from rest.
function* follow(form, pulse, shock, end, dt) {
  const beam = load(form, shock.C, dt), a = pulseOf(pulse, shock.f0 * dt), { SIDE, TARGET } = form;
  const amplitude = shock.N * form.gravity * dt * dt, lasts = 1 / (shock.f0 * dt);
  const run = { dt, every: 1, bins: [], snap: NaN };
  let before = SIDE * beam.w, n = 0;
  for (; n * dt < end; n += 1) {
    advance(beam, n < lasts + 1 ? amplitude * a(n) : 0);
    const now = SIDE * beam.w;
    if (Number.isNaN(run.snap) && now <= TARGET) run.snap = (n - 1 + (before - TARGET) / (before - now)) * dt;
    before = now;
    keep(run, n, halfway(beam));
    if (n % CHUNK === CHUNK - 1) yield;
  }
  const isAcross = SIDE * halfway(beam).w <= form.SADDLE;
  return { ...run, steps: n, isAcross, failed: !Number.isFinite(beam.y + beam.w) };
}

function keep(run, n, { w, y, energy, beam }) {
  const { bins } = run, last = bins[Math.floor(n / run.every)];
  if (last) {
    [last.low, last.high] = [Math.min(last.low, w), Math.max(last.high, w)];
    return;
  }
  if (bins.length === 2 * SAMPLES) {
    const both = (bin, next) => ({ ...bin, low: Math.min(bin.low, next.low), high: Math.max(bin.high, next.high) });
    run.bins = bins.flatMap((bin, place) => (place % 2 ? [] : [both(bin, bins[place + 1])]));
    run.every *= 2;
  }
  run.bins.push({ low: w, high: w, y, energy, beam });
}

"use strict";
// Follows one shock: the step of docs/theory.md, "One step" and "Stops", in the names of its
// equations. Lengths are in um, masses in ng, times in us; in a run time is counted in steps, and
// forces are times dt^2.

const CHUNK = 20000, BLOCK = 128, SAMPLES = 400, EXACT = 2, ROUNDING = 1e-12;

// The coefficients of a device, by name, from its row of the study's table.
function formOf(names, row) {
  const form = Object.fromEntries(names.map((name, n) => [name, row[n]]));
  let from = names.length;
  const take = (size) => row.subarray(from, (from += size));
  const k = form.modes;
  return { ...form, kappa: take(k), sq0: take(k), f: take(k), e: take(k), rest: take(k), S: take(k * k) };
}

// The time step in which a motion is shown, us.
function stepOf(form, pulse, { N, f0 }, limits) {
  const swing = 1 / (pulse.swings * f0);
  const resolved = Math.max(swing / limits.perSwing, form.shortest);
  const step = Math.min(form.longest, resolved, swing / limits.few);
  const speed = (frequency) => N * form.gravity * Math.min(pulse.grossArea / f0, pulse.variation / frequency);
  const struck = form.isBack || pulse.strikes ? form.tightening * speed(form.omega) : 0;
  const own = form.ownTightening * speed(form.arch);
  return step / Math.max((step * Math.sqrt(struck + own)) / limits.turn, 1);
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

// The state of a beam at rest and its mass, with every mode scaled to mass 1.
function load(form, C, dt) {
  const { modes, e } = form, square = dt * dt;
  const kappa = form.kappa.map((stiffness) => stiffness * square);
  const stretch = kappa.map((stiffness) => {
    const half = Math.min(Math.sqrt(stiffness), EXACT) / 2;
    return 1 / Math.sqrt((half / Math.tan(half)) ** 2 + stiffness / 4);
  });
  const scaled = (vector) => vector.map((value, i) => value * stretch[i]);
  const drag = ((form.held + form.warmth * C) * dt) / 2, beamDrag = (form.alpha * dt) / 2;
  const M = form.M, mass = M + (form.K * square) / 4, b = 1 / (1 + beamDrag);
  const beam = {
    modes, dt, M, z0: form.z0, residual: form.residual / square, K: form.K * square,
    k: form.contact * square, axial: form.axial * square, toward: form.toward, away: form.away,
    restitution: form.restitution, b, B: 1 / (mass + drag), isHeld: false, keep: (mass - drag) / (mass + drag),
    beamKeep: (1 - beamDrag) * b, gamma: (b * form.axial * square) / 2,
    kappa: kappa.map((stiffness, i) => stiffness * stretch[i] ** 2), sq0: scaled(form.sq0),
    f: scaled(form.f), e: scaled(e), S: form.S.map((element, ij) =>
      stretch[Math.floor(ij / modes)] * stretch[ij % modes] * element),
    p: form.rest.map((value, i) => value / stretch[i]), d: new Float64Array(modes),
    u: new Float64Array(modes), free: new Float64Array(modes), a: 0, y: 0, dy: 0, q: 0, x: 0, w: 0, P: 0,
  };
  for (let i = 0; i < modes; i += 1) {
    let u = 2 * beam.sq0[i];
    for (let j = 0; j < modes; j += 1) u += beam.S[i * modes + j] * beam.p[j];
    beam.q += u * beam.p[i];
    beam.w += beam.e[i] * beam.p[i];
  }
  beam.x = beam.w - beam.z0;
  return beam;
}

// Advances p and y from n to n + 1, and q and x half way, under the acceleration a dt^2; w and P
// become those at n.
function advance(beam, a) {
  if (beam.y < -beam.toward && beam.dy < 0) strike(beam, -beam.toward);
  if (beam.y > beam.away && beam.dy > 0) strike(beam, beam.away);
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
    F = ep - beam.y - beam.z0 + (ef - dyFree) / 2 - (gamma * eu * rho) / t;
    beam.P = force(m, F, beta, beam.k / 2);
  };
  press(beam.isHeld ? 0 : beam.B);
  if (beam.isHeld && (pulls + beam.P) * beam.y < 0) {
    beam.isHeld = false;
    press(beam.B);
  }
  const r = (rho - (b * eu * beam.P) / 2) / t, pull = 2 * gamma * r;
  beam.w = ep - beam.residual * beam.P;
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
  const { M, K, k, a, restitution, dy: d } = beam, m = beam.y - d / 2;
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

// Energies half way through the last step, pJ, and w(L/2) there from rest.
function halfway({ modes, p, d, kappa, e, axial, q, M, K, k, y, dy, x, residual, dt }) {
  let beam = (axial * q * q) / 4, w = -residual * k * Math.max(0, x);
  for (let i = 0; i < modes; i += 1) {
    beam += (d[i] * d[i] + kappa[i] * p[i] * (p[i] - d[i])) / 2;
    w += e[i] * (p[i] - d[i] / 2);
  }
  const middle = y - dy / 2, square = dt * dt;
  const mass = (M * dy * dy + K * middle * middle) / 2, contact = (k * Math.max(0, x) ** 2) / 2;
  return { w, y: middle, beam: beam / square, mass: mass / square, contact: contact / square };
}

// Whether the energies keep the beam on its side of the saddle, once the pulse is over.
function isSettled({ barrier, saddle, z0, K }, { w, beam, mass, contact }) {
  if (beam + mass + contact < barrier * (1 - ROUNDING)) return true;
  return beam < barrier * (1 - ROUNDING) && w < saddle && saddle < z0 - Math.sqrt((2 * mass) / K);
}

// Follows a shock { N, f0 (1/us), C } to the horizon, or for a swing of the mass after it has settled.
// Yields every CHUNK steps, so that the page can respond. A bin of `every` steps holds the extremes of
// w in `low` and `high`, and other values at its first step; w and y count from rest.
function* follow(form, pulse, shock, horizon, side, dt) {
  const beam = load(form, shock.C, dt), a = pulseOf(pulse, shock.f0 * dt);
  const amplitude = shock.N * form.gravity * dt * dt, lasts = 1 / (shock.f0 * dt);
  const swing = Number.isFinite(form.omega) ? (2 * Math.PI) / (form.omega * dt) : lasts;
  const run = { dt, every: 1, low: [], high: [], y: [], energy: [], beam: [], snap: NaN, settled: NaN };
  let [end, before] = [lasts + horizon / dt, side * beam.w];
  let n = 0;
  for (; n < end; n += 1) {
    advance(beam, n < lasts + 1 ? amplitude * a(n) : 0);
    const now = side * beam.w;
    if (Number.isNaN(run.snap) && now <= form.target) run.snap = (n - 1 + (before - form.target) / (before - now)) * dt;
    before = now;
    const half = halfway(beam);
    keep(run, n, half);
    if (n % BLOCK === BLOCK - 1 && n > lasts && Number.isNaN(run.settled) && isSettled(form, half)) {
      run.settled = n * dt;
      end = Math.min(end, n + swing);
    }
    if (n % CHUNK === CHUNK - 1) yield;
  }
  run.steps = n;
  run.isAcross = side * halfway(beam).w <= side * form.saddle;
  run.failed = !Number.isFinite(beam.y + beam.w);
  return run;
}

function keep(run, n, { w, y, beam, mass, contact }) {
  const { low, high } = run, last = Math.floor(n / run.every);
  if (last === low.length) {
    if (last === 2 * SAMPLES) {
      for (const key of ["y", "energy", "beam"]) run[key] = run[key].filter((_, bin) => bin % 2 === 0);
      run.low = low.filter((_, bin) => bin % 2 === 0).map((value, bin) => Math.min(value, low[2 * bin + 1]));
      run.high = high.filter((_, bin) => bin % 2 === 0).map((value, bin) => Math.max(value, high[2 * bin + 1]));
      run.every *= 2;
    }
    for (const [key, value] of Object.entries({ low: w, high: w, y, energy: beam + mass + contact, beam })) run[key].push(value);
    return;
  }
  low[last] = Math.min(low[last], w);
  high[last] = Math.max(high[last], w);
}

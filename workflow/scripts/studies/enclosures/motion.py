"""One run of the modal equations, enclosed: what is claimed of it holds for the exact solution.

Taylor polynomials are followed, exact functions of time that nearly solve the equations. With r =
(p, sqrt(M) y), the distance of the true solution from them in the norm r.B r + |r'|^2 grows no
faster than at the rate |L^-1 (B - T)| / 2, where B = L L^T and T is any tangent stiffness in a
tube around them (Gronwall, with the logarithmic norm), and by their defects: what they leave of
the equations, the wrong sign of the overlap near a contact event, and rounding from step to step.
That growth, some e^100, is paid for by digits.
"""

from typing import NamedTuple

import numpy as np
from flint import arb, arb_mat, arb_poly, ctx

from snapmap.beam.modal import contact_stiffness

BITS, ORDER, STEP = 352, 104, 0.25
"""Of the arithmetic; terms of the polynomials; us."""
PIECES, SAMPLES, HALVINGS = 4, 32, 64
"""Parts of a step in which the tangent is enclosed; places where an event is looked for."""
GRID = 2.0**280
"""Of events, per us: so that all times are exact."""
SOFTEST = 0.1
"""Least eigenvalue of the metric, 1/us^2."""
ROUGH, TUBE = 64, 2.0**-50
"""Bits where only a range is asked; radius in which the true solution must stay."""


class Equations(NamedTuple):
    """Those of `ModalBeam` and its mass under a versed sine, without stops; numbers of flint."""

    stiffness: list
    geometric: list
    slope_start: list
    load: list
    midpoint: list
    axial: arb
    residual: arb
    contact: arb
    mass: arb
    spring: arb
    gap: arb
    beam_damping: arb
    damping: arb
    amplitude: arb
    duration: arb


def equations(model, amplitude, f0, C):
    """Those of a model of one device; amplitude: multiples of g; f0: Hz."""
    device, modal = model.device, model.modal
    columns = [_numbers(row) for row in modal.geometric]
    symmetric = [
        [(a + b) / 2 for a, b in zip(*both, strict=True)]
        for both in zip(columns, map(list, zip(*columns, strict=True)), strict=True)
    ]
    vectors = modal.slope_start, modal.load, modal.midpoint
    stiff = contact_stiffness(device, modal.residual)
    numbers = modal.axial, modal.residual, stiff, device.mass, device.spring, device.gap
    return Equations(
        _numbers(modal.stiffness),
        symmetric,
        *(_numbers(vector) for vector in vectors),
        *map(_numbers, (*numbers, device.beam.damping, C)),
        amplitude=arb(amplitude) * arb(device.gravity),
        duration=arb(10) ** 6 / arb(f0),
    )


def _numbers(values):
    return [_numbers(one) for one in values] if np.ndim(values) else arb(float(values))


class Piece(NamedTuple):
    """Polynomials over a time h from `start` on: p and y; closed: whether contact presses."""

    p: list
    y: arb_poly
    closed: bool
    start: arb
    h: arb


def dot(a, b):
    return sum((x * y for x, y in zip(a, b, strict=True)), arb(0))


def slopes(e, p):
    """S p + S q0."""
    return [s + dot(row, p) for s, row in zip(e.slope_start, e.geometric, strict=True)]


def stretch(e, p, u):
    """p.S p + 2 p.S q0; u: of `slopes`."""
    return dot(p, [a + s for a, s in zip(u, e.slope_start, strict=True)])


def pulse(e, start, terms):
    """Taylor coefficients of a(t) from `start` on."""
    if start >= e.duration:
        return [arb(0)] * terms
    omega = 2 * arb.pi() / e.duration
    sine, cosine = (omega * start).sin_cos()
    turns, found, scale = (cosine, -sine, -cosine, sine), [], -e.amplitude / 2
    for j in range(terms):
        found.append(scale * turns[j % 4])
        scale *= omega / (j + 1)
    found[0] += e.amplitude / 2
    return found


def expand(e, state, closed, start, h):
    """Taylor polynomials from a state (p, v, y, w) on, their coefficients exact numbers."""
    k, a = len(e.load), pulse(e, start, ORDER)
    p, v, y, w = [[c] for c in state[0]], [[c] for c in state[1]], [state[2]], [state[3]]
    u, both, force = [[] for _ in range(k)], [[] for _ in range(k)], []
    for j in range(ORDER - 1):
        last = [c[j] for c in p]
        for i in range(k):
            u[i].append(dot(e.geometric[i], last) + (e.slope_start[i] if j == 0 else 0))
            both[i].append(u[i][j] + (e.slope_start[i] if j == 0 else 0))
        force.append(-e.axial * sum(dot(p[i], both[i][::-1]) for i in range(k)))
        overlap = dot(e.midpoint, last) - y[j] - (e.gap if j == 0 else 0)
        press = e.contact * overlap if closed else arb(0)
        for i in range(k):
            push = dot(force, u[i][::-1]) - e.stiffness[i] * last[i] - e.beam_damping * v[i][j]
            v[i].append((push - e.load[i] * a[j] - e.midpoint[i] * press).mid() / (j + 1))
            p[i].append(v[i][j] / (j + 1))
        pull = (press - e.spring * y[j] - e.damping * w[j]) / e.mass - a[j]
        w.append(pull / (j + 1))
        y.append(w[j] / (j + 1))
    exact = [arb_poly([c.mid() for c in one]) for one in (*p, y)]
    return Piece(exact[:-1], exact[-1], closed, start, h)


def overlap_of(e, piece):
    return dot(e.midpoint, piece.p) - piece.y - e.gap


def defect(e, piece):
    """What the polynomials leave of the equations, at most, over the piece, in the norm."""
    u, first = slopes(e, piece.p), piece.start
    axial, x = -e.axial * stretch(e, piece.p, u), overlap_of(e, piece)
    a, press = arb_poly(pulse(e, first, ORDER)), e.contact * x if piece.closed else arb(0)
    left = [
        p.derivative().derivative()
        - (axial * s - k * p - f * a - g * press)
        + e.beam_damping * p.derivative()
        for p, s, k, f, g in zip(piece.p, u, e.stiffness, e.load, e.midpoint, strict=True)
    ]
    speed = piece.y.derivative()
    pull = press - e.spring * piece.y - e.damping * speed - e.mass * a
    left.append(e.mass.sqrt() * (speed.derivative() - (1 / e.mass) * pull))
    sizes = [sum(abs(c) * piece.h**j for j, c in enumerate(one.coeffs())) for one in left]
    # What is cut off of the pulse, and where contact has the wrong sign.
    cut = e.amplitude * (2 * arb.pi() / e.duration * piece.h) ** ORDER / arb(ORDER).gamma()
    wrong = shortfall(x if piece.closed else -x, arb(0), piece.h) * e.contact
    loads, grips = [*e.load, e.mass.sqrt()], [*e.midpoint, 1 / e.mass.sqrt()]
    return norm(sizes) + norm(loads) * cut + norm(grips) * wrong


def shortfall(poly, low, high, halvings=HALVINGS):
    """How far below 0 a polynomial goes at most between two places."""
    inside = low.union(high)
    if poly(inside) >= 0:
        return arb(0)
    ends = [(-poly(end)).upper() for end in (low, high)]
    slope = poly.derivative()(inside)
    if slope > 0 or slope < 0 or not halvings:
        worst = ends if halvings else [(-poly(inside)).upper()]
        return max(arb(0), *worst)
    middle = (low + high) / 2
    parts = shortfall(poly, low, middle, halvings - 1), shortfall(poly, middle, high, halvings - 1)
    return max(parts)


def norm(values):
    sizes = [arb(value.abs_upper()) for value in values]
    return dot(sizes, sizes).sqrt()


class Verdict(NamedTuple):
    """What is proven of a run, and how.

    snaps: None if neither a snap nor that there is none could be shown
    time: us, of the proof; radius: of the enclosure, in the norm; growth: decimal digits lost
    rest: barrier less energy, pJ
    """

    snaps: bool | None
    time: float
    radius: float
    growth: float
    events: int
    rest: float


def tangent(e, p, pressing):
    """Stiffness of small (p, sqrt(M) y), mass-normalised; pressing: the share of contact."""
    k, u = len(p), slopes(e, p)
    axial, grip = e.axial * stretch(e, p, u), [*e.midpoint, -1 / e.mass.sqrt()]
    found = arb_mat([[pressing * e.contact * g * h for h in grip] for g in grip])
    found[k, k] += e.spring / e.mass
    for i in range(k):
        found[i, i] += e.stiffness[i]
        for j in range(k):
            found[i, j] += axial * e.geometric[i][j] + 2 * e.axial * u[i] * u[j]
    return found


class Metric:
    """The norm r.B r + |r'|^2, B near the tangent at p, and the growth of distances in it.

    reach: the most of each r per unit of the norm
    """

    def __init__(self, e, p, closed):
        table = tangent(e, p, arb(int(closed))).table()
        rough = np.array(table, float)
        n, shift = len(table), max(0.0, SOFTEST - float(np.linalg.eigvalsh(rough)[0]))
        self.matrix = arb_mat(n, n)
        for i in range(n):
            for j in range(n):
                self.matrix[i, j] = (table[min(i, j)][max(i, j)] + shift * (i == j)).mid()
        self.inverse = self.matrix.inv()
        self.reach = [self.inverse[i, i].sqrt() for i in range(n)]
        parts = [[row[: i + 1] for row in self.matrix.table()[: i + 1]] for i in range(n)]
        if not all(arb_mat(part).det() > 0 for part in parts):
            raise ArithmeticError("the norm is none")

    def of(self, e, state):
        """The norm of (p, v, y, w), magnitudes."""
        r = arb_mat([[c] for c in (*state[0], e.mass.sqrt() * state[2])])
        size = r.transpose() * arb_mat([[abs(b) for b in row] for row in self.matrix.table()]) * r
        return (size[0, 0] + dot(state[1], state[1]) + e.mass * state[3] * state[3]).sqrt()

    def rate(self, e, p, pressing):
        """Of growth while p is in balls; pressing: the share of contact, a ball in [0, 1]."""
        apart = self.matrix - tangent(e, p, pressing)
        square = (apart * self.inverse * apart).trace()
        return arb(square.abs_upper()).sqrt() / 2

    def over(self, before):
        """By how much the norm may exceed that of the metric before."""
        apart = before.inverse * (self.matrix - before.matrix)
        return (1 + arb((apart * apart).trace().abs_upper()).sqrt()).sqrt()


def spread(poly, low, high):
    """A ball around a polynomial's values between two places."""
    middle, half = (low + high) / 2, (high - low) / 2
    return poly(middle) + poly.derivative()(low.union(high)) * arb(0, half)


def pressed(x):
    """Overlap where it presses, and the share of contact, in [0, 1]."""
    if x > 0 or x < 0:
        return (x, arb(1)) if x > 0 else (arb(0), arb(0))
    return arb(0).union(arb(x.abs_upper())), arb(0.5, 0.5)


def around(e, piece, metric):
    """Rate of growth over the piece, and the least w; within the tube."""
    *reach, of_y = (TUBE * r for r in metric.reach)
    aside = dot(map(abs, e.midpoint), reach)
    x, w = overlap_of(e, piece), dot(e.midpoint, piece.p)
    growth, least = arb(0), []
    for i in range(PIECES):
        ends = piece.h * i / PIECES, piece.h * (i + 1) / PIECES
        p = [spread(one, *ends) + arb(0, r) for one, r in zip(piece.p, reach, strict=True)]
        overlap, share = pressed(spread(x, *ends) + arb(0, aside + of_y / e.mass.sqrt()))
        growth += metric.rate(e, p, share) * piece.h / PIECES
        least.append((spread(w, *ends) - aside - e.residual * e.contact * overlap).lower())
    return growth, min(least)


def event(e, piece):
    """When the overlap first has the wrong sign, within the piece; None if it keeps to its own."""
    x = overlap_of(e, piece) * (1 if piece.closed else -1)
    places = [piece.h * i / SAMPLES for i in range(SAMPLES + 1)]
    wrong = next((i for i in range(1, SAMPLES + 1) if x(places[i]).mid() < 0), None)
    if wrong is None:
        return None
    low, high, speed = places[wrong - 1], places[wrong], x.derivative()
    for _ in range(30):
        middle = ((low + high) / 2).mid()
        low, high = (low, middle) if x(middle).mid() < 0 else (middle, high)
    for _ in range(6):
        low = (low - x(low) / speed(low)).mid()
    at = (low * GRID).floor() / GRID
    return at if 0 < at < piece.h else None


def follow(e, barrier, floor, until):
    """Follow a cell until it snaps, or has less energy than `floor` and no shock; `Verdict`.

    barrier: a `Barrier`; floor: pJ, no more than any shape with the saddle's midpoint has
    """
    target, zero = arb(float(barrier.second - barrier.first)), arb(0)
    saddle = arb(float(barrier.midpoint))
    # Below the floor contact gives w no more than this.
    stays = saddle - e.residual * (2 * e.contact * floor).sqrt() > target
    state = [zero] * len(e.load), [zero] * len(e.load), zero, zero
    time, radius, growth, closed, events, rest = zero, zero, zero, False, 0, zero
    snaps, metric = None, Metric(e, state[0], closed)
    while time < until and radius < TUBE:
        metric, before = Metric(e, state[0], closed), metric
        piece = expand(e, state, closed, time, (time / STEP + 1).floor() * STEP - time)
        at = event(e, piece)
        piece = piece if at is None else piece._replace(h=at)
        with ctx.workprec(ROUGH):
            added, least = around(e, piece, metric)
        changed, wandered = metric.over(before), piece.h * defect(e, piece)
        state, moved = end_of(piece, metric, e)
        radius = arb(((radius * changed + wandered) * added.exp() + moved).upper())
        growth, time = growth + added + changed.log(), time + piece.h
        closed, events = closed != (at is not None), events + (at is not None)
        p, v, y, speed = balls(e, metric, state, radius)
        force = e.contact * pressed(dot(e.midpoint, p) - y - e.gap)[0]
        rest = floor - energy(e, p, v, y, speed)
        if dot(e.midpoint, p) - e.residual * force < target:
            snaps = True
        elif not least > target:
            break
        elif stays and time >= e.duration and rest > 0 and dot(e.midpoint, p) > saddle:
            snaps = False
        if snaps is not None:
            break
    snaps = snaps if radius < TUBE else None
    lost = float(growth) / np.log(10)
    return Verdict(snaps, float(time), float(radius), lost, events, float(rest))


def end_of(piece, metric, e):
    """The state at the end of a piece, exact numbers, and the norm of what they leave out."""
    both = [*piece.p, piece.y]
    (*p, y), (*v, w) = ([one(piece.h) for one in part] for part in (both, map(slope, both)))
    exact = [c.mid() for c in p], [c.mid() for c in v], y.mid(), w.mid()
    return exact, metric.of(e, ([c.rad() for c in p], [c.rad() for c in v], y.rad(), w.rad()))


def slope(poly):
    return poly.derivative()


def balls(e, metric, state, radius):
    """All that the true (p, v, y, dy/dt) may be, by the radius in the norm."""
    p, v, y, w = state
    root, size = e.mass.sqrt(), [radius * r for r in metric.reach]
    near = [c + arb(0, r) for c, r in zip(p, size, strict=False)]
    return (
        near,
        [c + arb(0, radius) for c in v],
        y + arb(0, size[-1] / root),
        w + arb(0, radius / root),
    )


def energy(e, p, v, y, w):
    """Of beam, mass, spring and contact, pJ."""
    quadratic, x = stretch(e, p, slopes(e, p)), pressed(dot(e.midpoint, p) - y - e.gap)[0]
    bending = dot(e.stiffness, [c * c for c in p])
    swings = dot(v, v) + bending + e.mass * w * w + e.spring * y * y
    return (swings + e.axial * quadratic * quadratic / 2 + e.contact * x * x) / 2

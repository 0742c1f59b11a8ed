"""The conserving step of docs/theory.md as a plain loop, in the coordinates without the hat.

The kernel is held against it to rounding.
"""

import numpy as np

from snapmap.applications.histories.motion import Motion, record
from snapmap.numerics import pieces as curve
from snapmap.solver.cells import to_cells


def follow(model, pulse, amplitude, f0, C, dt, steps):
    """The `Motion` of one cell at every half step, and w(L/2) from rest at every instant."""
    device, (kappa, S, Sq0, f, e, axial, c, _) = model.device, model.modal
    M, K, alpha, k = device.mass, device.spring, device.beam.damping, 1 / (1 / device.contact + c)
    G, heavy, drag = inertia(kappa, dt), M + K * dt**2 / 4, alpha * dt / 2
    p_old = p = np.zeros(kappa.size)
    y_old = y = q = work = lost = a = 0.0
    x, motion, w = -device.gap, [], []
    for n in range(steps):
        way = device.stop_away if y > y_old else device.stop_toward
        if abs(y) > way and y * (y - y_old) > 0:
            middle, speed = (y_old + y) / 2, (y - y_old) / dt
            bounced = bounce(device, k, a, np.copysign(way, y), middle, speed, x)
            place, turned, pushed, taken = bounced
            x += (y_old + y) / 2 - place
            y_old, y = place - turned * dt / 2, place + turned * dt / 2
            work, lost = work + pushed, lost + taken
        a = amplitude * sample(pulse, f0, n, dt)

        # All that is ahead without N and P; A, B and D are what N, P and P take or give.
        b = 1 / (1 + drag)
        free = b * (2 * p - (1 - drag) * p_old - dt**2 * (kappa * p + f * a) / G)
        y_free = heavy * (2 * y - y_old) + C * dt / 2 * y_old - dt**2 * (M * a + K * y)
        D = dt**2 / (heavy + C * dt / 2)
        y_free *= D / dt**2
        u = S @ p + Sq0
        A, B = b * dt**2 * axial * u / G, b * dt**2 * e / G
        t = 1 + u @ A / 2
        r_free, r_give = (q + u @ free + p @ Sq0) / (2 * t), u @ B / (2 * t)
        ahead, give = e @ (p + free - A * r_free) / 2, e @ (B - A * r_give) / 2
        # A mass at rest on a stop stays there while the net force presses.
        beyond = np.nan if y != y_old or y not in (-device.stop_toward, device.stop_away) else y
        for y_ahead, yields in ((y, 0.0), (y_free, D)):
            F, beta = ahead - (y + y_ahead) / 2 - device.gap, give + yields / 2
            x_new = overlap(x, F, k * beta / 2)
            P = (F - x_new) / beta
            if (P - M * a - K * y) * beyond >= 0:
                break
        r = r_free - r_give * P
        p_new, y_new = free - A * r - B * P, y_ahead + yields * P

        q, x = 2 * r - q, x_new
        work -= a / 2 * (f @ (p_new - p_old) + M * (y_new - y_old))
        lost += (alpha * G @ (p_new - p_old) ** 2 + C * (y_new - y_old) ** 2) / (4 * dt)
        w.append(e @ p - c * P)
        p_old, p, y_old, y = p, p_new, y, y_new
        half = (p_old + p) / 2, (p - p_old) / dt, (y_old + y) / 2, (y - y_old) / dt
        motion.append(((n + 0.5) * dt, *half, q, work, lost))
    return Motion(*map(np.array, zip(*motion, strict=True))), np.array(w)


def inertia(kappa, dt):
    """With which a mode swings by itself as it should, up to 2 radians a step."""
    x = np.sqrt(kappa) * dt
    half = np.minimum(x, 2.0) / 2
    return (half / np.tan(half)) ** 2 + x**2 / 4


def sample(pulse, f0, n, dt):
    """The pulse at the instant n, where it jumps by its mean over a step."""
    pieces, ends = pulse.curve
    k = curve.at(pieces, 0, len(pieces), f0 * (n * dt))
    return curve.sample(pieces, k, ends, f0 * (n * dt), f0 * dt)


def overlap(m, F, h):
    """x at the next half step: the root of x + beta P(x) = F."""
    if m <= 0 and F <= 0:
        return F
    if m >= 0 and h * m <= F:
        return F - h * (F + m) / (1 + h)
    if m > 0:
        return (F + m - np.sqrt((F - m) ** 2 + 4 * h * m**2)) / 2
    return (F + m + np.sqrt((F - m) ** 2 - 4 * h * F * m)) / (2 + 2 * h)


def bounce(device, k, a, s, m, d, x):
    """m', d' of a mass that has passed the stop s, the work of the pulse and what the stop took."""
    M, e = device.mass, device.restitution

    def U(z):
        return device.spring * z**2 / 2 + k / 2 * max(0.0, x + m - z) ** 2 + M * a * z

    squared = d**2 + 2 / M * (U(m) - U(s))
    if squared <= 0 and (m - s) * d < 0:
        return m, d, 0.0, 0.0
    left = e**2 * max(squared, 0.0)
    place = s - e * (m - s)
    away = left - 2 / M * (U(place) - U(s))
    if away < 0:
        place, away = s, 0.0
    taken = max(M / 2 * (d**2 - away) + U(m) - U(place), 0.0)
    return place, -np.copysign(np.sqrt(away), d), M * a * (m - place), taken


def one_cell(device, pulse, N, f0, C, dt, steps):
    """The `Cells` of one cell that runs for so many steps, and its step; see `record`."""
    cells = to_cells(device, 0, [N], f0, C, 0.0, pulses=(pulse,))
    return cells._replace(t_end=np.array([(steps - 0.5) * dt])), np.array([dt])


def assert_followed(model, pulse, N, f0, C, dt, steps):
    """The kernel's motion of one cell is this one's to rounding; returns this one's, and w."""
    _, parts = record(model, *one_cell(model.device, pulse, N, f0, C, dt, steps))
    # The kernel's begins at rest at the instant 0, which this one leaves out.
    ours = [np.concatenate(columns)[1:] for columns in zip(*parts, strict=True)]
    theirs, w = follow(model, pulse, N * model.device.gravity, f0 * 1e-6, C, dt, steps)
    for key, one, other in zip(Motion._fields, ours, theirs, strict=True):
        np.testing.assert_allclose(one, other, 0, 1e-6 * abs(other).max(), err_msg=key)
    return theirs, w

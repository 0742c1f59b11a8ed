"""The handout's equations in modes of the beam, solved by SciPy for comparison."""

from collections.abc import Callable

import numpy as np
from numba import njit

from snapmap.beam.modal import ModalBeam, contact_stiffness
from snapmap.device.device import Device
from snapmap.solver.cells import Cells

Follow = Callable[[Cells], np.ndarray]
"""A function of cells that returns t_snap, us, or NaN for a cell that does not snap."""
TOLERANCE = 1e-6


def snap_target(device: Device) -> float:
    """Return the displacement at which the midpoint of a guided beam snaps, from rest, um."""
    return device.beam.second_equilibrium - device.beam.height


def by_scipy(device: Device, modal: ModalBeam, method: str, tolerance: float = TOLERANCE) -> Follow:
    """Make a function that follows cells by solve_ivp, in the pulse and after it, to the snap."""
    from scipy.integrate import solve_ivp

    (rate, w), size = compile_rate(device, modal), 2 * modal.load.size + 2
    target = snap_target(device)

    def snaps(t, x, *_):
        return w(x) - target

    def follow_cell(amplitude, f0, damping, t_end):
        x, start = np.zeros(size), 0.0
        for stop, a in ((1 / f0, amplitude), (t_end, 0.0)):
            options = {"args": (a, f0, damping), "events": snaps, "rtol": tolerance}
            run = solve_ivp(rate, (start, stop), x, method, **options)
            if run.t_events[0].size:
                return run.t_events[0][0]
            x, start = run.y[:, -1].copy(), stop
        return np.nan

    snaps.terminal, snaps.direction = True, -1
    return lambda cells: np.array([follow_cell(*cell) for cell in zip(*cells[2:6], strict=True)])


def compile_rate(device: Device, modal: ModalBeam):
    """Compile the rate of x = (p, y, p', y') by `ModalBeam` and eq. (2), and w(L/2) from rest.

    Returns rate(t, x, amplitude, f0, damping), and w(x).
    """
    mass, spring, penalty = device.mass, device.spring, contact_stiffness(device, modal.residual)
    stiffness, geometric, slope_start, load, midpoint, axial, residual, _ = modal
    modes, gap = load.size, device.gap

    @njit
    def press(x):
        return penalty * max(0.0, midpoint @ x[:modes] - x[modes] - gap)

    @njit
    def w(x):
        return midpoint @ x[:modes] - residual * press(x)

    @njit
    def rate(t, x, amplitude, f0, damping):
        p, y, y_rate = x[:modes], x[modes], x[-1]
        a = amplitude / 2 * (1 - np.cos(2 * np.pi * f0 * t))
        slope = geometric @ p + slope_start
        axial_force = -axial * p @ (slope + slope_start)
        contact = press(x)
        x_rate = np.empty_like(x)
        x_rate[: modes + 1] = x[modes + 1 :]
        x_rate[modes + 1 : -1] = axial_force * slope - stiffness * p - load * a - midpoint * contact
        x_rate[-1] = (contact - spring * y - damping * y_rate) / mass - a
        return x_rate

    rate(0.0, np.zeros(2 * modes + 2), 0.0, 0.0, 0.0)
    return rate, w

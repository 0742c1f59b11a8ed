"""What else a user could take: the handout's ODE in modes of the beam, by SciPy and by heyoka."""

from collections.abc import Callable

import numpy as np
from numba import njit

from snapmap.beam.modal import ModalBeam, contact_stiffness
from snapmap.device import Device
from snapmap.solver.cells import Cells

Follow = Callable[[Cells], np.ndarray]
"""Cells to t_snap, us, NaN for a cell that does not snap."""
TOLERANCE = 1e-6
TOUCH = 1e-7
"""Overlap, um, in which mass and beam start for heyoka: a gap of exactly 0 is an endless event."""
CHUNK = 1000
"""Steps of heyoka between two looks at its lanes."""


def snap_target(device: Device) -> float:
    """Where the midpoint of a guided beam snaps, from where it rests, um."""
    return device.beam.second_equilibrium - device.beam.height


def by_scipy(device: Device, modal: ModalBeam, method: str, tolerance: float = TOLERANCE) -> Follow:
    """Follow cells one by one with solve_ivp, in two legs, pulse and rest, to the event w2."""
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
    """Compile d/dt of x = (p, y, p', y'), from `ModalBeam` and eq. (2), and w(L/2) from rest."""
    mass, spring, penalty = device.mass, device.spring, contact_stiffness(device, modal.residual)
    stiffness, geometric, slope_start, load, midpoint, axial, residual, _ = modal
    modes = load.size

    @njit
    def press(x):
        return penalty * max(0.0, midpoint @ x[:modes] - x[modes])

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


def by_heyoka(device: Device, modal: ModalBeam, width: int, tolerance: float = TOLERANCE) -> Follow:
    """Follow cells in `width` lanes of heyoka, each refilled as it falls free.

    Contact is an event that switches its stiffness: left to `relu`, it opens and closes only at
    the ends of heyoka's steps, at the same speed.
    """
    import heyoka as hy

    def switch_contact(integrator, sign, lane):
        integrator.pars[3, lane] = penalty if sign > 0 else 0.0
        return True

    penalty = contact_stiffness(device, modal.residual)
    ode, w, overlap = heyoka_system(device, modal)
    falling = hy.event_direction.negative
    snap = hy.t_event_batch(w - snap_target(device), direction=falling)
    contact = hy.t_event_batch(overlap, callback=switch_contact)
    integrator = hy.taylor_adaptive_batch(
        ode,
        np.zeros((len(ode), width)),
        pars=np.zeros((4, width)),
        tol=tolerance,
        t_events=[snap, contact],
    )
    return lambda cells: Lanes(integrator, penalty, cells).follow()


def heyoka_system(device: Device, modal: ModalBeam):
    """The ODE, w(L/2) - rise and the overlap in heyoka's terms.

    Its parameters: half of the pulse's amplitude, 2 pi f0, C, and lambda or 0 with open contact.
    """
    import heyoka as hy

    modes = range(modal.load.size)
    half, turn, damping, stiffness = (hy.par[i] for i in range(4))
    p, v = ([hy.expression(f"{name}{i}") for i in modes] for name in "pv")
    y, z = hy.make_vars("y", "z")
    a = half * (1.0 - hy.cos(turn * hy.time))
    start = modal.slope_start
    slope = [hy.sum([modal.geometric[i, j] * p[j] for j in modes]) + start[i] for i in modes]
    axial_force = -modal.axial * hy.sum([p[i] * (slope[i] + start[i]) for i in modes])
    w = hy.sum([modal.midpoint[i] * p[i] for i in modes])
    overlap = w - y + TOUCH
    contact = stiffness * overlap
    ode = [(p[i], v[i]) for i in modes]
    for i in modes:
        inner = axial_force * slope[i] - modal.stiffness[i] * p[i]
        ode.append((v[i], inner - modal.load[i] * a - modal.midpoint[i] * contact))
    pull = (contact - device.spring * y - damping * z) / device.mass
    return [*ode, (y, z), (z, pull - a)], w - modal.residual * contact, overlap


class Lanes:
    """One call's cells in the lanes of an integrator of `heyoka_system`."""

    def __init__(self, integrator, contact: float, cells: Cells):
        self.integrator, self.contact, self.cells = integrator, contact, cells
        self.queue = list(np.argsort(-cells.f0, kind="stable"))
        self.cell_in = [None] * integrator.batch_size
        self.time, self.stop = np.zeros((2, integrator.batch_size))
        self.t_snap = np.full(cells.f0.size, np.nan)

    def follow(self) -> np.ndarray:
        """Follow all cells; returns t_snap, us."""
        for lane in range(self.integrator.batch_size):
            self._refill(lane)
        while any(cell is not None for cell in self.cell_in):
            self.integrator.set_time(self.time)
            self.integrator.propagate_until(self.stop, max_steps=CHUNK)
            self.time = self.integrator.time.copy()
            for lane, (outcome, *_) in enumerate(self.integrator.propagate_res):
                if self.cell_in[lane] is not None:
                    self._look(lane, self.cell_in[lane], snapped=int(outcome) == -1)
        return self.t_snap

    def _look(self, lane, cell, snapped):
        if snapped:
            self.t_snap[cell] = self.time[lane]
        if snapped or self.time[lane] >= self.cells.t_end[cell]:
            self._refill(lane)
        elif self.time[lane] >= self.stop[lane]:
            self.integrator.pars[0, lane] = 0.0
            self.stop[lane] = self.cells.t_end[cell]

    def _refill(self, lane):
        self.time[lane] = self.stop[lane] = self.integrator.state[:, lane] = 0.0
        self.integrator.reset_cooldowns(lane)
        self.cell_in[lane] = cell = self.queue.pop() if self.queue else None
        if cell is not None:
            amplitude, f0, damping, _ = (values[cell] for values in self.cells[2:6])
            self.integrator.pars[:, lane] = amplitude / 2, 2 * np.pi * f0, damping, self.contact
            self.stop[lane] = 1 / f0

"""Cells followed by a user's own solver, a function of a single cell."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..device.device import Device
from ..files.text import show
from ..pulse.pulse import Pulse
from .cells import Cells
from .laws import fault_of, of_user
from .settings import Run

LANES = 1  # cells that are followed side by side


class Cell(NamedTuple):
    """A single cell for a solver, with the units of `Cells` and the start of `Run`."""

    device: Device
    pulse: Pulse
    amplitude: float
    f0: float
    damping: float
    t_end: float
    start: str

    def acceleration(self, t: np.ndarray | float) -> np.ndarray:
        """Return the acceleration of the frame along +z, um/us^2, at times, us, of any shape."""
        return self.amplitude * self.pulse.at(np.asarray(self.f0 * t))


def march(model, cells: Cells, dt: np.ndarray, settings: Run) -> tuple[np.ndarray, ...]:
    """Follow cells by the solver of `Laws`; takes and returns what `plain_loop.march` does.

    The solver takes a `Cell` and a step, us, and returns t_snap, us: None or NaN for no snap, inf
    for a run not to trust. Raises ValueError, one line, for any other answer, or an error in it.
    """
    t_snap, unknown = np.empty(dt.size), np.full(dt.size, np.nan)
    unit = model.laws.unit_of_C
    for i in range(dt.size):
        device, pulse, *values = (column[i].item() for column in cells[:-1])
        alone = model.pick(device).device
        cell = Cell._make((alone, cells.pulses[pulse], *values, settings.start))
        N, f0, C = cell.amplitude / alone.gravity, 1e6 * cell.f0, cell.damping
        name = getattr(model.laws.solver, "__name__", "solver")
        with of_user(f"{name} at N = {N:.10g}, f0 = {f0:.10g} Hz, C = {C:.10g} {unit}".strip()):
            answer = model.laws.solver(cell, dt[i].item())
        t_snap[i] = _time_of(answer, model.laws.solver)
    lost = np.where(np.isinf(t_snap), np.inf, 0.0)
    return t_snap, unknown, np.zeros(dt.size, np.int8), lost, unknown, unknown, unknown


def _time_of(answer: object, solver: Callable) -> float:
    """Convert the answer of a solver to a time, us, or NaN; raises ValueError for a wrong one."""
    if answer is None:
        return np.nan
    numbers = int | float | np.integer | np.floating
    if isinstance(answer, bool) or not isinstance(answer, numbers) or answer < 0:
        needs = "return the time of the snap (us), None for no snap, or inf for a run not to trust"
        raise fault_of(solver, "solver", f"returns {show(answer)}; {needs}")
    return float(answer)

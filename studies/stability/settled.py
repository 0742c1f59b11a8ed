"""Whether settled runs stay in their wells for another 10 ms."""

from dataclasses import replace
from itertools import product

import numpy as np

from snapmap.device.device import Device
from snapmap.solver.cells import to_cells
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines, Elements
from snapmap.solver.settings import STAY, Run
from snapmap.solver.simd_loop import watch

from ..common import few, with_beam
from ..tables import Table

N, F0 = np.linspace(600, 2400, 26), np.geomspace(100, 3e4, 16)
MODELS = Cosines(modes=3), Cosines(modes=5), Elements()
DAMPINGS = (0.025, 25.0)
SETTINGS = Run()
FURTHER = 10_000.0
"""Time for which runs are followed after the pulse, us."""
HEAD = ["beam", "contact, N/m", "settled", "left their shape"]
FREE = {"free": 1.0, "imperfection": 0.02, "thickness": 1.4, "residual_stress": -40.0}
FREE |= {"damping": 4e-4}
"""A beam that is free to tilt and still has a second shape; um, MPa, 1/us."""


def followed_on(device: Device) -> str:
    """Make a table of how many cells settle, and how many of these leave their well later."""
    rows = []
    tilting = with_beam(device, **FREE)
    beams = few({"guided": device, "free": tilting}).items()
    for (name, beam), contact in product(beams, few((40.0, np.inf))):
        models = [build_model(replace(beam, contact=contact), chosen) for chosen in few(MODELS)]
        counts = np.sum([count(model, C) for model in models for C in few(DAMPINGS)], axis=0)
        rows.append([name, f"{contact:g}", *(str(number) for number in counts)])
    return Table("stability_stays", HEAD, rows)


def count(model, C):
    """Count the cells that settle at the default step, and those of them that leave."""
    f0, amplitude = (values.ravel() for values in np.meshgrid(few(F0), N))
    cells = to_cells(model.device, 0, amplitude, f0, C, SETTINGS.horizon)
    observed = model.follow_once(cells, SETTINGS)
    believed = observed.energy_error <= SETTINGS.energy_tolerance
    settled = np.flatnonzero(np.isfinite(observed.t_settled) & believed)
    left = 0
    for first in range(0, settled.size, LANES):
        some = settled[first : first + LANES]
        left += leavers(model, cells.take(some), observed.t_settled[some], observed.well[some])
    return settled.size, left


def leavers(model, cells, t_settled, well):
    """Count cells, LANES at most, that are on the other side of the saddle after they have settled.

    t_settled, well: as observed, (cells,)
    """
    dt, saddle = model.steps.of(cells, STAY), model.barrier.midpoint
    steps = np.ceil((1 / cells.f0 + FURTHER) / dt).astype(int)
    left = np.zeros(dt.size, bool)
    for first, (w, _) in watch(model, cells, dt, steps):
        later = (first + np.arange(len(w))[:, np.newaxis] + 0.5) * dt >= t_settled
        # A run that blew up is on neither side.
        stays = np.where(well == 1, w > saddle, w < saddle)
        left |= (later & ~stays).any(axis=0)
    return int(left.sum())

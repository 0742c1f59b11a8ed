"""The largest stress in the beams of many cells."""

import numpy as np

from ..device.device import Device
from ..files.counting import count
from . import simd_loop
from .adaptive import choose_model
from .cells import Cells
from .models import Follows, Model, deciders
from .options import Chosen, Elements, Reference
from .settings import Run

STRETCH = 4
"""Number of steps of which the length of a run is a multiple."""


def motion_levels(device: Device, model: Chosen, settings: Run) -> tuple[Follows, ...]:
    """Build the levels of a model that decide cells; of `reference`, those of its elements."""
    if isinstance(model, Reference):
        model = Elements(model.elements)
    return choose_model(device, model, settings.start).levels


def largest_stress(device: Device, model: Chosen, cells: Cells, settings: Run) -> np.ndarray:
    """Find the largest tensile stress in the beam of each cell up to its end, MPa, (cells,).

    device: batch to which the cells belong
    """
    finest = motion_levels(device, model, settings)[-1:]
    halvings = finest[0].follow(cells, settings.but(repeat=False)).halvings
    decided, stress = np.stack([0 * halvings, halvings]), np.empty(halvings.size)
    for at, part in deciders(finest, cells.device, decided, np.arange(halvings.size)):
        chosen = cells.take(at)
        stress[at] = follow_stress(part, chosen, chosen.t_end, settings)
    return stress


def follow_stress(
    model: Model, cells: Cells, window: np.ndarray, settings: Run, stretch: int = STRETCH
) -> np.ndarray:
    """Follow cells for the largest tensile stress in the beam of each, MPa, (cells,).

    window: time followed, us, (cells,), rounded up to a multiple of `stretch` steps
    """
    dt = model.time_steps(cells, settings.but(until="moved"))
    steps = stretch * np.ceil(window / (stretch * dt)).astype(np.int64)
    rows, stress = simd_loop.stress_rows(model)[cells.device], np.empty(steps.size)

    def follow(these):
        group = cells.take(these), dt[these], steps[these]
        stress[these] = simd_loop.largest_stress(model, *group, rows[these], settings.start)
        count(these.size)

    simd_loop.in_lanes(follow, steps, settings.threads)
    return stress

"""The largest stress in the beams of many cells."""

import numpy as np

from ..beam.basis import PLACES
from ..beam.stress import stress_of
from ..device.device import Device
from .adaptive import choose_model
from .cells import Cells
from .models import Follows, Model, deciders
from .options import Chosen, Elements, Reference
from .settings import Run
from .simd_loop import in_lanes, watch


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


def follow_stress(model: Model, cells: Cells, window: np.ndarray, settings: Run) -> np.ndarray:
    """Follow cells for the largest tensile stress in the beam of each, MPa, (cells,).

    window: time followed, us, (cells,)
    """
    dt = model.time_steps(cells, settings.but(until="moved"))
    steps = np.ceil(window / dt).astype(np.int64)
    rows, stress = stress_rows(model)[cells.device], np.full(steps.size, -np.inf)

    def follow(these):
        """Follow up to LANES cells."""
        group = cells.take(these), dt[these], steps[these], settings.start
        for first, (_, seen) in watch(model, *group, rows[these]):
            step = first + np.arange(len(seen))[:, np.newaxis]
            most = np.where(step < steps[these], seen, -np.inf).max(axis=0)
            stress[these] = np.maximum(stress[these], most)

    in_lanes(follow, steps, settings.threads)
    return stress


def stress_rows(model) -> np.ndarray:
    """Tabulate the stress of each device's beam, MPa, (devices, PLACES + 1, modes + 2).

    The first PLACES rows are bending stress per coordinate, per contact force, and at rest; in the
    last row, the last two numbers are axial stress per stretch, and at rest.
    """
    tables = np.zeros((len(model.device), PLACES + 1, model.modes + 2))
    for i, rows in enumerate(tables):
        picked = model.pick(i)
        form = stress_of(picked.device.beam, picked.basis, picked.modal.shapes)
        rows[:-1] = np.column_stack([form.bending, form.residual, form.rest])
        rows[-1, -2:] = picked.modal.axial / form.area, form.tension
    return tables

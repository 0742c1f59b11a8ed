"""The motion of many cells in brief: bands over time bins, and the largest stress."""

from collections.abc import Mapping

import numpy as np

from ..device.device import Device
from ..files.counting import count
from . import simd_loop
from .adaptive import choose_model
from .cells import Cells
from .kernel.trace import SAMPLE
from .models import Follows, Model, deciders
from .settings import Settings

BANDS = "w_low", "w_high", "z_mass", "energy", "beam_energy"
"""Bands that are kept of each time bin."""


def motion_levels(device: Device, model: Mapping, settings: Settings) -> tuple[Follows, ...]:
    """Build the levels that decide cells; `reference` gives the same elements in their modes.

    model: as in a config
    """
    if model.get("laws"):
        raise ValueError("model.laws: stress and traces are not of such a model; leave them out")
    name = "elements" if model["name"] == "reference" else model["name"]
    return choose_model(device, {**model, "name": name}, settings.start).levels


def largest_stress(device: Device, model: Mapping, cells: Cells, settings: Settings) -> np.ndarray:
    """Find the largest tensile stress in the beam of each cell up to its end, MPa; (cells,).

    device: a batch with a strength, of which the cells are; model: as in a config
    """
    finest = motion_levels(device, model, settings)[-1:]
    halvings = finest[0].follow(cells, settings._replace(repeat=False)).halvings
    decided, stress = np.stack([0 * halvings, halvings]), np.empty(halvings.size)
    for at, part in deciders(finest, cells.device, decided, np.arange(halvings.size)):
        chosen = cells.take(at)
        stress[at] = follow_motion(part, chosen, chosen.t_end, 1, settings)[-1]
    return stress


def follow_motion(
    model: Model, cells: Cells, window: np.ndarray, bins: int, settings: Settings
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Follow cells, and keep BANDS over time bins and the largest stress.

    model: of one step for all of them; window: time followed, us, (cells,)
    Returns values, (BANDS, bins, cells), the lengths of the bins, us, and stresses, MPa; (cells,).
    """
    saddle = model.barrier
    first, barrier = (np.asarray(value)[cells.device] for value in (saddle.first, saddle.energy))
    device = model.device
    gap = np.where(device.is_alone, np.nan, device.gap)
    origin = np.stack([first, first, first + gap[cells.device]])
    dt = model.time_steps(cells, settings._replace(until="moved"))
    width = SAMPLE * np.ceil(window / (bins * SAMPLE * dt)).astype(np.int64)
    values, stress = np.empty((len(BANDS), bins, width.size)), np.full(width.size, np.nan)
    rows = None
    if np.isfinite(device.strength).any():
        rows = simd_loop.stress_rows(model)[cells.device]

    def follow(these):
        of, stress_of = cells.device[these], None if rows is None else rows[these]
        w_range, instants, stress[these] = simd_loop.trace(
            model, cells.take(these), dt[these], width[these], bins, stress_of, settings.start
        )
        # Half way through the step in which it bounces the mass is beyond a stop.
        np.clip(instants[0], -device.stop_toward[of], device.stop_away[of], instants[0])
        values[:3, :, these] = origin[:, np.newaxis, these] + [*w_range, instants[0]]
        with np.errstate(divide="ignore", invalid="ignore"):  # no barrier: nothing is below it
            values[3:, :, these] = instants[1:] / barrier[these]
        count(these.size)

    simd_loop.in_lanes(follow, width, settings.threads)
    return values, width * dt, stress

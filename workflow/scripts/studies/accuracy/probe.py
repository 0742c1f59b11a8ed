"""What every case is asked: thresholds that are well posed on the device, and a map."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from snapmap.beam.equilibria import static_threshold
from snapmap.device import Device, batch
from snapmap.numerics.portable import geometric, linear
from snapmap.pulse import Shocks
from snapmap.solver.adaptive import Survey
from snapmap.solver.cells import Rows, to_rows
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from snapmap.thresholds.islands import survey

from .plans import Plan

MOST_ROWS = 12
"""So many thresholds of the study are asked for; where none is clean, the device's own as well."""
# ASSUME: slow pulses and a mass damped to Q = 5 make thresholds well posed on most devices.
OWN_PULSES, OWN_DAMPING = np.array([0.1, 0.2, 0.4]), 0.2
"""Frequencies over the device's own, and damping over sqrt(K M), of the device's own rows."""


class Probe(NamedTuple):
    """What every case is asked.

    rows: of the thresholds; N: about where each lies, multiples of g, NaN where none was found
    clean: whether labels change once along N as the judges see it, (rows,)
    axes: C, f0 and N of the map
    shocks: of the study; its rows and its map have an index, or axes, of them
    """

    rows: Rows
    N: np.ndarray
    clean: np.ndarray
    axes: dict[str, np.ndarray]
    shocks: Shocks


def list_rows(axes: Mapping[str, Sequence[float]], shocks: Shocks) -> Rows:
    """Rows of a study at both ends of C and the quarter points of f0, for every pulse.

    Of more than MOST_ROWS so many, evenly chosen.
    """
    C, f0 = (np.sort(np.asarray(axes[key], float)) for key in ("C", "f0"))
    quarters = np.round(np.array([0.25, 0.5, 0.75]) * (f0.size - 1)).astype(int)
    pulse = np.arange(len(shocks.pulses))[:, np.newaxis, np.newaxis]
    few, C = f0[np.unique(quarters)], np.unique(C[[0, -1]])[:, np.newaxis]
    rows = to_rows(0, few, C, pulse, shocks.pulses)
    count = rows.f0.size
    return rows.some(np.unique(np.linspace(0, count - 1, min(count, MOST_ROWS)).astype(int)))


def list_own_rows(device: Device, slowest: float, shocks: Shocks) -> Rows:
    """Rows of the device's own periods and damping, of every pulse; f0 from `slowest` (Hz) on."""
    f0 = device.own_frequency / (2 * math.pi) * 1e6 * OWN_PULSES
    damping = OWN_DAMPING * math.sqrt(device.spring * device.mass)
    pulse = np.arange(len(shocks.pulses))[:, np.newaxis]
    return to_rows(0, f0[f0 >= slowest], damping, pulse, shocks.pulses)


def make_probe(
    device: Device,
    axes: Mapping[str, Sequence[float]],
    settings: Settings,
    plan: Plan,
    shocks: Shocks,
    slowest: float = 0.0,
) -> Probe:
    """Choose what to ask on one device: rows on which judges find a threshold, and a map.

    axes: C, f0 and N of the sweep; slowest: least f0 of the device's own rows, Hz
    """
    C, f0, N = (np.sort(np.asarray(axes[key], float)) for key in ("C", "f0", "N"))
    wide = geometric(f0[0], f0[-1], plan.side), linear(N[0], N[-1], plan.side)
    of_map = {"C": np.unique(C[[0, -1]]), "f0": np.unique(wide[0]), "N": np.unique(wide[1])}
    rows = list_rows(axes, shocks)
    found, clean = look(device, rows, settings, plan.judges)
    if not clean.any():
        own = list_own_rows(device, slowest, shocks)
        seen = look(device, own, settings, plan.judges)
        both = zip(rows[:-1], own[:-1], strict=True)
        rows = Rows(*(np.append(*pair) for pair in both), shocks.pulses)
        found, clean = np.append(found, seen[0]), np.append(clean, seen[1])
    kept = np.isfinite(found)
    return Probe(rows.some(kept), found[kept], clean[kept], of_map, shocks)


def look(
    device: Device, rows: Rows, settings: Settings, judges: Sequence[int]
) -> tuple[np.ndarray, np.ndarray]:
    """About where thresholds lie, multiples of g, NaN for none, and which are clean; (rows,).

    judges: cosines of the models that scan, decide and doubt
    """
    if not rows.f0.size:
        return np.empty(0), np.empty(0, bool)
    devices = batch([device])
    scans, decides, doubts = (build_model(devices, "cosines", modes=n) for n in judges)
    models = Survey(scans, decides, doubts, None, static_threshold(devices))
    found = survey(models, rows, settings)
    return found.N_first, np.isfinite(found.N_first) & (found.ragged == 0)

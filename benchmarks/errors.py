"""Thresholds of every model, beside converged ones."""

import dataclasses
import math

import numpy as np
from contenders import FEWEST, HANDOUT, MODELS, REFERENCE, heyokas
from workload import by_model, map_cells, same_labels, threshold

from snapmap.device import Device
from snapmap.io.markdown import DASH, table
from snapmap.solver.models import build_model
from studies.few import few

PULSES = 500.0, 1500.0
"""f0, Hz."""
NONE = np.full(len(PULSES), np.nan)
HEAD = [
    *("", "40 N/m, 500 Hz", "1500 Hz", "hard, 500 Hz", "1500 Hz"),
    *("to exact 5 elements, 500 Hz", "1500 Hz"),
]
LEGEND = """
The lowest N that snaps within 300 us of the pulse, by refining a grid to 1e-6. First row: converged
({cosines} cosines, a quarter of the step limit), g. The others: differences from it, g; the last
two columns: from five elements without error in time (handout, a fifth of the step limit), 40 N/m.
"""


def error_section(device: Device) -> str:
    """Everyone's errors."""
    hard = dataclasses.replace(device, contact=math.inf)
    finest = {"name": "cosines", "modes": few(16, 5), "step": 0.25}
    soft_limit, hard_limit = (_model(d, **finest) for d in (device, hard))
    exact = _model(device, "handout", step=0.2)
    rows = [["converged", *(f"{N:.2f}" for N in (*soft_limit, *hard_limit))]]
    for name, model in few(MODELS, FEWEST).items():
        soft = _model(device, **model)
        stiff = NONE if name == REFERENCE else _model(hard, **model)
        nodal = soft - exact if name in (REFERENCE, HANDOUT) else NONE
        rows.append(_row(name, soft - soft_limit, stiff - hard_limit, nodal))
    rivals = heyokas(device)
    for name, follow in rivals.items():
        soft = _thresholds(device, follow)
        rows.append(_row(name, soft - soft_limit, NONE, soft - exact))
    note = _agreement(device, *rivals.popitem()) if rivals else ""
    legend = LEGEND.format(cosines=finest["modes"])
    return f"\n## Error of the threshold\n\n{table(HEAD, rows)}{legend}{note}"


def _model(device, name, **options):
    return _thresholds(device, by_model(build_model(device, name, **options)))


def _thresholds(device, follow):
    return np.array([threshold(device, follow, f0) for f0 in PULSES])


def _row(name, *differences):
    values = np.concatenate(differences)
    return [name, *(DASH if np.isnan(value) else f"{value:+.3f}" for value in values)]


def _agreement(device, name, follow):
    """Hold a rival's snap times against those of the handout model at a small step."""
    cells = map_cells(device)
    fine = by_model(build_model(device, "handout", step=0.05))(cells)
    found = follow(cells)
    apart = abs(found - fine)[np.isfinite(found - fine)]
    return (
        f"\n{name}, on the map above, against the handout model at a twentieth of the step limit:\n"
        f"{same_labels(found, fine)} of {fine.size} labels agree, and {np.sum(apart < 1e-3)} of "
        f"{apart.size} snap times are within 0.001 us (median {np.median(apart):.0e} us).\n"
    )

"""How many proven runs stay in their wells if they are followed on for 5 ms: docs/stability.md.

PYTHONPATH=workflow/scripts ./run python -m studies.proofs
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from snapmap import load_device
from snapmap.beam.modal import contact_stiffness
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings

from .markdown import table

ROOT = Path(__file__).resolve().parents[3]
N, F0 = np.linspace(600, 2400, 14), np.geomspace(100, 3e4, 10)
MODELS = {
    "3 cosines": {"name": "cosines", "modes": 3},
    "5 cosines": {"name": "cosines", "modes": 5},
    "5 elements": {"name": "handout"},
}
SETTINGS = Settings()
FURTHER, STRIDE = 5000.0, 4
"""How long runs are followed on, us, and the steps between two looks at them."""


def main():
    device = load_device(ROOT / "config" / "config.yaml")
    rows = []
    for contact in (40.0, np.inf):
        for label, options in MODELS.items():
            for C in (0.025, 25.0):
                one = replace(device, contact=contact)
                proven, left = count(build_model(one, **options), C)
                rows.append([label, f"{contact:g}", f"{C:g}", str(proven), str(left)])
    print(table(["model", "contact, N/m", "C", "proven", "left their well"], rows))


def count(model, C):
    """How many cells are proven at the model's own step, and how many of them leave their well."""
    f0, amplitude = (values.ravel() for values in np.meshgrid(F0, N))
    cells = to_cells(model.device, 0, amplitude, f0, C, SETTINGS.horizon)
    seen = model.follow_once(cells, SETTINGS)
    proven = (seen.well > 0) & (seen.energy_error <= SETTINGS.energy_tolerance)
    left = 0
    for i in np.flatnonzero(proven):
        time, w = follow_on(model, *(values[i] for values in cells[1:4]))
        later = w[time >= seen.t_settled[i]]
        above = later > model.barrier.midpoint
        left += (~above if seen.well[i] == 1 else above).any()
    return proven.sum(), left


def follow_on(model, amplitude, f0, damping):
    """Times and w(L/2) - rise of one cell, bit for bit as `follow_once` does, and beyond."""
    steps = int(np.ceil((1 / f0 + FURTHER) / model.dt))
    with np.errstate(invalid="ignore"):  # a run may blow up long after its proof
        motion, form = model.loop().record(model, amplitude, f0, damping, steps, STRIDE)
    w = motion.u @ form.midpoint
    contact = contact_stiffness(model.device, form.residual) * np.maximum(0, w - motion.y)
    return motion.time, w - form.residual * contact


if __name__ == "__main__":
    main()

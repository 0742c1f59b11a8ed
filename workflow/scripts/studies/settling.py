"""What share of the snapped cells settles in which well, by damping and step: docs/stability.md.

PYTHONPATH=workflow/scripts ./run python -m studies.settling [--small]
"""

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from snapmap import load_device
from snapmap.io.markdown import number, table
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model
from snapmap.solver.settings import STAY, Settings

from .few import few

ROOT = Path(__file__).resolve().parents[3]
N, F0, C = np.linspace(600, 2400, 61), np.geomspace(100, 3e4, 31), 25.0
HORIZON = 6000.0
STEPS = ({}, {"step": 0.07})
"""The default, and a small share of the limit."""
HEAD = ["cosines", "beam damping, 1/us", "step, us", "latched", "returned"]


def main():
    device, rows = load_device(ROOT / "config" / "config.yaml"), []
    for modes, damping in product(few((3, 4, 5)), few((0.0, 4e-4))):
        one = replace(device, beam=replace(device.beam, damping=damping))
        for step in STEPS:
            model = build_model(one, "cosines", modes=modes, **step)
            dt = model.steps.longest[STAY].item()
            shares = (f"{share:.1%}" for share in settled(model))
            rows.append([str(modes), f"{damping:g}", number(dt), *shares])
    print(table(HEAD, rows))


def settled(model):
    """Shares of the snapped cells that are proven to stay in the second and in the first shape."""
    f0, amplitude = (values.ravel() for values in np.meshgrid(few(F0), N))
    cells = to_cells(model.device, 0, amplitude, f0, C, HORIZON)
    seen = model.follow(cells, Settings(HORIZON, threads=2))
    snapped = np.isfinite(seen.t_snap)
    well = np.where(np.isfinite(seen.t_settled), seen.well, 0)[snapped]
    return np.mean(well == 2), np.mean(well == 1)


if __name__ == "__main__":
    main()

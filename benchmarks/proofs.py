"""How many proven runs stay in their wells if they are followed on for 5 ms: docs/stability.md.

PYTHONPATH=workflow/scripts ./run python benchmarks/proofs.py
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from markdown import table

from snapmap import load_device
from snapmap.cells import follow_once, to_cells
from snapmap.lanes import device_coefficients, follow_one
from snapmap.modal import contact_stiffness
from snapmap.models import build_model
from snapmap.protocol import Protocol

ROOT = Path(__file__).resolve().parents[1]
N, F0 = np.linspace(600, 2400, 14), np.geomspace(100, 3e4, 10)
MODELS = {"3 cosines": ("cosines", {"modes": 3}), "5 cosines": ("cosines", {"modes": 5})}
MODELS["5 elements"] = ("handout", {})
FURTHER, STRIDE = 5000.0, 4


def main():
    device = load_device(ROOT / "config" / "config.yaml")
    rows = []
    for contact in (40.0, np.inf):
        for label, (name, options) in MODELS.items():
            for C in (0.025, 25.0):
                one = replace(device, contact=contact)
                proven, left = count(build_model(one, name, **options), C)
                rows.append([label, f"{contact:g}", f"{C:g}", str(proven), str(left)])
    print(table(["model", "contact, N/m", "C", "proven", "left their well"], rows))


def count(model, C):
    """How many cells are proven at the model's own step, and how many of them leave their well."""
    f0, amplitude = (values.ravel() for values in np.meshgrid(F0, N))
    cells = to_cells(model.device, amplitude, f0, np.full(f0.size, C), Protocol().horizon)
    facts = follow_once(model, cells, Protocol())
    proven = (facts.well > 0) & (facts.energy_error <= Protocol().energy_tolerance)
    left = 0
    for i in np.flatnonzero(proven):
        time, w = follow_on(model, *(values[i] for values in cells[:3]))
        later = w[time >= facts.t_settled[i]]
        above = later > model.barrier.midpoint
        left += (~above if facts.well[i] == 1 else above).any()
    return proven.sum(), left


def follow_on(model, amplitude, f0, damping):
    """Times and w(L/2) - rise of one cell, bit for bit as `follow_once` does, and beyond."""
    modal, dt = model.modal, model.dt
    row = device_coefficients(model, target=-np.inf)
    steps = int(np.ceil((1 / f0 + FURTHER) / dt))
    p, _, y, *_ = follow_one(modal.load.size, row, dt, amplitude, f0, damping, steps, STRIDE)
    w = p @ modal.midpoint
    contact = contact_stiffness(model.device, modal.residual) * np.maximum(0, w - y)
    return np.arange(len(w)) * STRIDE * dt, w - modal.residual * contact


if __name__ == "__main__":
    main()

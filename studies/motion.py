"""By how much models and steps move the motion after the snap: docs/accuracy.md.

./run python -m studies motion
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from snapmap import load_device
from snapmap.io.markdown import number, table
from snapmap.solver.cells import to_cells
from snapmap.solver.kernel.trace import SAMPLE
from snapmap.solver.models import build_model
from snapmap.solver.outcome import REPEATED_STEP, work_error
from snapmap.solver.settings import MOVE, Settings
from snapmap.solver.simd_loop import trace

from .common import ROOT, few, stepped

N, F0, C = np.linspace(1100, 3000, 4), np.geomspace(1e3, 8e3, 4), 25.0
CONTACTS = (40.0, 400.0, np.inf)
MODELS = {
    "3 cosines": {"name": "cosines", "modes": 3},
    "5 cosines": {"name": "cosines", "modes": 5},
    "7 cosines": {"name": "cosines", "modes": 7},
    "5 elements": {"name": "handout"},
}
FINEST, FINE, OTHER = "7 cosines", 0.002, 0.003
"""What models are held against: which of them, its step, us, and one to hold that against."""
STEPPED, STEPS = "5 cosines", (0.01, 0.02, 0.04, 0.08, 0.137)
"""What is held against itself at step FINE, and its steps, us."""
SETTINGS = Settings(horizon=1000.0)
PLANE = np.linspace(600, 2400, 25), np.geomspace(100, 2e4, 16)
"""N and f0, Hz, of cells of which only what a cube says is asked."""
BINS = 2000
"""In which the position of the mass is looked at."""
SPREAD = ["work: median", "third quartile", "largest"]
HEAD = ["contact, N/m", "model", "step, us", *SPREAD, "t_snap, us", "highest z, um"]
TOLD = ["reported: median", "third quartile", "largest"]
HEAD_PLANE = ["contact, N/m", "model", "cells", "number", *TOLD, "within 2 %"]


class Moved(NamedTuple):
    """How the cells moved; (cells,): work of the pulse, pJ; snap, us; highest z_M, um."""

    work: np.ndarray
    t_snap: np.ndarray
    highest: np.ndarray


def main():
    device = load_device(ROOT / "config" / "damped.yaml")
    models, steps, plane = [], [], []
    for contact in few(CONTACTS):
        one = replace(device, contact=contact)
        built = {name: build_model(one, **options) for name, options in few(MODELS, 3).items()}
        for name, model in built.items():
            plane += [[f"{contact:g}", name, *row] for row in tell(model)]
        finest = follow(stepped(built[FINEST], FINE))
        built[FINEST + ", fine"] = stepped(built[FINEST], OTHER)
        for name, model in built.items():
            off = compare(follow(model), finest)
            errors = told(model, cells_of(device))[0]
            models.append([f"{contact:g}", name, number(step_of(model)), *off, *spread(errors)])
        fine = follow(stepped(built[STEPPED], FINE))
        for dt in few(STEPS):
            off = compare(follow(stepped(built[STEPPED], dt)), fine)
            steps.append([f"{contact:g}", STEPPED, number(dt), *off])
    print(table([*HEAD, *TOLD], models))
    print(table(HEAD, steps))
    print(table(HEAD_PLANE, plane))


def step_of(model):
    """The step in which the model's motion is followed, us, of pulses as long as here."""
    return model.steps.longest[MOVE].item()


def cells_of(device, N=N, f0=F0):
    f0, amplitude = (values.ravel() for values in np.meshgrid(few(f0), N))
    return to_cells(device, 0, amplitude, f0, C, SETTINGS.horizon).take(np.arange(f0.size))


def follow(model):
    """Follow the cells with the model's own step."""
    cells = cells_of(model.device)
    seen = model.follow_once(cells, SETTINGS._replace(until="moved"))
    dt = model.steps.of(cells, MOVE)
    width = SAMPLE * np.ceil(cells.t_end / (BINS * SAMPLE * dt)).astype(int)
    y, _, _ = trace(model, cells, dt, width, BINS)[1]
    return Moved(seen.pulse_work, seen.t_snap, y.max(axis=0))


def compare(found, converged):
    """Spread of the error of the work, median of that of the snap, and the largest of z."""
    snap = np.nanmedian(abs(found.t_snap - converged.t_snap))
    highest = abs(found.highest - converged.highest).max()
    return [*spread(abs(found.work / converged.work - 1)), number(snap), number(highest)]


def told(model, cells):
    """What a cube says: the `work_error` of each cell, and whether it snaps."""
    seen, again = (one.follow(cells, SETTINGS) for one in (model, model.with_step(REPEATED_STEP)))
    return work_error(seen, again), np.isfinite(seen.t_snap)


def tell(model):
    """Rows on those cells of the plane that snap, and on the others."""
    errors, snapped = told(model, cells_of(model.device, *PLANE))
    for name, some in {"that snap": errors[snapped], "others": errors[~snapped]}.items():
        yield name, str(some.size), *spread(some), f"{np.mean(some < 0.02):.1%}"


def spread(errors):
    """Median, third quartile and largest, in per cent."""
    return [f"{number(100 * value)} %" for value in np.quantile(errors, [0.5, 0.75, 1.0])]


if __name__ == "__main__":
    main()

"""The effect of models and steps on the motion after the snap, for docs/accuracy.md.

./run python -m studies motion
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from snapmap import load_device
from snapmap.applications.histories.motion import record
from snapmap.files.text import table
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model
from snapmap.solver.outcome import REPEATED_STEP, work_error
from snapmap.solver.settings import MOVE, Settings

from .common import ROOT, few, number, stepped

N, F0, C = np.linspace(1100, 3000, 4), np.geomspace(1e3, 8e3, 4), 25.0
CONTACTS = (40.0, 400.0, np.inf)
MODELS = {
    "3 cosines": {"name": "cosines", "modes": 3},
    "5 cosines": {"name": "cosines", "modes": 5},
    "7 cosines": {"name": "cosines", "modes": 7},
    "5 elements": {"name": "elements"},
}
FINEST, FINE, OTHER = "7 cosines", 0.002, 0.003
"""Name of the reference, its step, and another step that shows its error, us."""
SETTINGS = Settings(horizon=1000.0)
SPREAD = ["work: median", "third quartile", "largest"]
HEAD = ["contact, N/m", "model", "step, us", *SPREAD, "t_snap, us", "highest z, um"]
HEAD += ["reported: median", "third quartile", "largest"]


class Moved(NamedTuple):
    """Work of the pulse, pJ; snap, us; highest z_M from rest, um; (cells,)."""

    work: np.ndarray
    t_snap: np.ndarray
    highest: np.ndarray


def main():
    device = load_device(ROOT / "config" / "damped.yaml")
    rows = []
    for contact in few(CONTACTS):
        held = replace(device, contact=contact)
        models = {name: build_model(held, **options) for name, options in few(MODELS, 3).items()}
        finest = follow(stepped(models[FINEST], FINE))
        models[FINEST + ", fine"] = stepped(models[FINEST], OTHER)
        for name, model in models.items():
            off = compare(follow(model), finest)
            dt = model.steps.longest[MOVE].item()
            rows.append([f"{contact:g}", name, number(dt), *off, *spread(work_errors(model))])
    print(table(HEAD, rows))


def cells_of(device):
    """Make the cells of a device, all N at each F0, (cells,)."""
    f0, amplitude = (values.ravel() for values in np.meshgrid(few(F0), N))
    return to_cells(device, 0, amplitude, f0, C, SETTINGS.horizon).take(np.arange(f0.size))


def follow(model):
    """Follow the cells with the default step of the model."""
    cells = cells_of(model.device)
    observed = model.follow_once(cells, SETTINGS._replace(until="moved"))
    dt = model.steps.of(cells, MOVE)
    steps = np.ceil(cells.t_end / dt).astype(int)
    shocks = zip(*cells[2:5], dt, steps, strict=True)
    runs = [record(model, cells.pulses[0], *shock)[1] for shock in shocks]
    highest = np.array([max(part.y.max() for part in parts) for parts in runs])
    return Moved(observed.pulse_work, observed.t_snap, highest)


def compare(moved, converged):
    """Write the spread of the errors of the work, the median of the snap's, the largest of z's."""
    snap = np.nanmedian(abs(moved.t_snap - converged.t_snap))
    highest = abs(moved.highest - converged.highest).max()
    return [*spread(abs(moved.work / converged.work - 1)), number(snap), number(highest)]


def work_errors(model):
    """Estimate the error of the work of each cell as a cube does, (cells,)."""
    cells, models = cells_of(model.device), (model, model.with_step(REPEATED_STEP))
    return work_error(*(model.follow(cells, SETTINGS) for model in models))


def spread(errors):
    """Write median, third quartile and largest, in per cent."""
    return [f"{number(100 * value)} %" for value in np.quantile(errors, [0.5, 0.75, 1.0])]


if __name__ == "__main__":
    main()

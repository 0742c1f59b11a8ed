"""By how much models and steps move the motion after the snap: docs/accuracy.md.

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
"""What models are held against: which of them, its step, us, and one to hold that against."""
SETTINGS = Settings(horizon=1000.0)
SPREAD = ["work: median", "third quartile", "largest"]
HEAD = ["contact, N/m", "model", "step, us", *SPREAD, "t_snap, us", "highest z, um"]
HEAD += ["reported: median", "third quartile", "largest"]


class Moved(NamedTuple):
    """How the cells moved; (cells,): work of the pulse, pJ; snap, us; highest z_M, um."""

    work: np.ndarray
    t_snap: np.ndarray
    highest: np.ndarray


def main():
    device = load_device(ROOT / "config" / "damped.yaml")
    models = []
    for contact in few(CONTACTS):
        one = replace(device, contact=contact)
        built = {name: build_model(one, **options) for name, options in few(MODELS, 3).items()}
        finest = follow(stepped(built[FINEST], FINE))
        built[FINEST + ", fine"] = stepped(built[FINEST], OTHER)
        for name, model in built.items():
            off = compare(follow(model), finest)
            dt = model.steps.longest[MOVE].item()
            models.append([f"{contact:g}", name, number(dt), *off, *spread(told(model))])
    print(table(HEAD, models))


def cells_of(device):
    f0, amplitude = (values.ravel() for values in np.meshgrid(few(F0), N))
    return to_cells(device, 0, amplitude, f0, C, SETTINGS.horizon).take(np.arange(f0.size))


def follow(model):
    """Follow the cells with the model's own step."""
    cells = cells_of(model.device)
    seen = model.follow_once(cells, SETTINGS._replace(until="moved"))
    dt = model.steps.of(cells, MOVE)
    steps = np.ceil(cells.t_end / dt).astype(int)
    shocks = zip(*cells[2:5], dt, steps, strict=True)
    runs = [record(model, cells.pulses[0], *shock)[1] for shock in shocks]
    highest = np.array([max(part.y.max() for part in parts) for parts in runs])
    return Moved(seen.pulse_work, seen.t_snap, highest)


def compare(found, converged):
    """Spread of the error of the work, median of that of the snap, and the largest of z."""
    snap = np.nanmedian(abs(found.t_snap - converged.t_snap))
    highest = abs(found.highest - converged.highest).max()
    return [*spread(abs(found.work / converged.work - 1)), number(snap), number(highest)]


def told(model):
    """What a cube says of the error of the work of each cell."""
    cells = cells_of(model.device)
    seen, again = (one.follow(cells, SETTINGS) for one in (model, model.with_step(REPEATED_STEP)))
    return work_error(seen, again)


def spread(errors):
    """Median, third quartile and largest, in per cent."""
    return [f"{number(100 * value)} %" for value in np.quantile(errors, [0.5, 0.75, 1.0])]


if __name__ == "__main__":
    main()

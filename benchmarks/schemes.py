"""What either scheme costs with soft, stiff and hard contact: docs/performance.md.

PYTHONPATH=workflow/scripts ./run python benchmarks/schemes.py [--small]
"""

from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
from timing import take_turns

from snapmap import load_device
from snapmap.io.markdown import number, table
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model
from snapmap.solver.schemes import SCHEMES
from snapmap.solver.settings import UNTIL, Settings
from studies.few import few

ROOT = Path(__file__).resolve().parents[1]
SIDE, C, ROUNDS = 16, 0.025, 5
CONTACTS = (40.0, 4000.0, np.inf)
MODELS = {
    "3 cosines": {"name": "cosines", "modes": 3},
    "4 cosines": {"name": "cosines", "modes": 4},
    "5 cosines": {"name": "cosines", "modes": 5},
    "8 cosines": {"name": "cosines", "modes": 8},
    "5 elements": {"name": "handout"},
}
HEAD = [
    *("model", "contact, N/m", "until", "explicit, us per cell", "repeated"),
    *("conserving, us per cell", "repeated", "ratio", "taken"),
]


def main():
    device = load_device(ROOT / "config" / "config.yaml")
    N, f0 = np.meshgrid(np.linspace(600, 2400, SIDE), few(np.geomspace(300, 20e3, SIDE)))
    rows = []
    for (name, options), contact, until in product(few(MODELS).items(), CONTACTS, few(UNTIL)):
        one = replace(device, contact=contact)
        cells = to_cells(one, 0, N.ravel(), f0.ravel(), C, Settings().horizon)
        rows.append([name, f"{contact:g}", until, *compare(one, options, cells, until)])
    print(f"{N.size} cells, C = {C} uN us/um, best of {few(ROUNDS)} rounds in turns\n")
    print(table(HEAD, rows))


def compare(device, options, cells, until):
    """Times per cell and shares followed again, by scheme, and which one the rule takes."""
    models = {scheme: build_model(device, **options, scheme=scheme) for scheme in SCHEMES}
    settings = Settings(until=until)
    tasks = {scheme: partial(model.follow, cells, settings) for scheme, model in models.items()}
    take_turns(tasks, 1)  # compiles
    runs = take_turns(tasks, few(ROUNDS))
    shown = []
    for run in runs.values():
        repeated = float((run.result.halvings > 0).mean())
        shown += [number(1e6 * run.seconds / cells.f0.size), f"{repeated:.0%}"]
    explicit, conserving = (run.seconds for run in runs.values())
    return [*shown, f"{explicit / conserving:.2g}", build_model(device, **options).scheme]


if __name__ == "__main__":
    main()

"""Hard cases and settled cells, for docs/accuracy.md.

./run python -m studies stability [--device SECTION] [--small]
"""

from snapmap import Cosines, Study, sweep
from snapmap.numerics.portable import geometric, linear

from ..common import command_device, few
from ..tables import write
from .cases import CASES, MODELS
from .measure import measure
from .settled import followed_on
from .tables import tables

GRID = {"N": linear(600, 2400, 61), "f0": geometric(100, 3e4, 31), "C": [0.025, 25.0, 200.0]}
"""Axes of the cells that may settle: multiples of g, Hz, uN us/um."""
DAMPINGS = [0.0, 4e-4, 4e-3]
"""Dampings of the beam, 1/us."""


def main() -> None:
    device = command_device()
    cases = measure(device, few(CASES, 2), few(MODELS, 2))
    grid = {key: few(values, 3) for key, values in GRID.items()}
    study = Study(device, Cosines(modes=4), horizon=6000.0)
    settled = sweep(study, **grid, axes={"damping": few(DAMPINGS, 2)})
    write("stability", *tables(cases, settled), followed_on(device))

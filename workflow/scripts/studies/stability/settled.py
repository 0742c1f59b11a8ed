"""Which cells settle with less and more damping of the beam."""

from snapmap.numerics.portable import geometric, linear
from snapmap.sweeps.cube import sweep

GRID = {
    "N": linear(600, 2400, 61),
    "f0": geometric(100, 3e4, 31),
    "C": [0.025, 25.0, 200.0],
}
"""Multiples of g, Hz, uN us/um."""
MODEL = {"model": "cosines", "modes": 4}
HORIZON = 6000.0
"""Followed after the pulse, us."""


def settled(device, beam_dampings, threads):
    """Sweep and repeat the grid for each beam damping, 1/us; one dataset over `damping`."""
    asked = {"horizon": HORIZON, "repeat": True, "threads": threads, "damping": beam_dampings}
    found = sweep(device, **GRID, **MODEL, **asked)
    return found.assign_attrs(title="Cells proven to have settled, by damping of mass and beam")

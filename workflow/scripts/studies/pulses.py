"""What the numbers of docs/pulses.md are: both sides of the device, and what kinks and jumps cost.

PYTHONPATH=workflow/scripts ./run python -m studies.pulses [--small]
"""

from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from snapmap import load_device, simulate, threshold
from snapmap.io.markdown import table
from snapmap.pulse import SHAPES

from .few import few

ROOT = Path(__file__).resolve().parents[3]
STEPS, FINE = (0.8, 0.4, 0.2), 0.025
N, F0, C = 100, 4100.0, 25.0


def main():
    device = load_device(ROOT / "config" / "config.yaml")
    print(sides(device), kinks(device), sep="\n")


def sides(device):
    """Thresholds from both sides at 5 kHz with little damping."""
    found = threshold(device, [5000.0], [0.025], direction="both", threads=2).squeeze()
    keys = "N_first", "N_error", "N_half", "half_error"
    rows = [
        [direction, *(f"{found[key].sel(direction=direction).item():.0f}" for key in keys)]
        for direction in found.direction.values.tolist()
    ]
    return table(["direction", *keys], rows)


def kinks(device):
    """Largest relative error of a flying mass's displacement after the pulse, by step and shape."""
    errors = [errors_of(device, shape) for shape in few(list(SHAPES))]
    rows = [[f"{step:g}", *(f"{one[i]:.1e}" for one in errors)] for i, step in enumerate(STEPS)]
    return table(["step", *few(list(SHAPES))], rows)


def errors_of(device, shape):
    """The error for each of STEPS."""
    runs = []
    for step in (*STEPS, FINE):
        asked = {"pulse": shape, "direction": "-z", "horizon": 30.0, "step": step}
        run = simulate(device, N, F0, C, "cosines", **asked)
        runs.append((run.time.values, run.z_mass.values))
    late = 1.02e6 / F0 + np.linspace(0, 20, 100)
    *paths, exact = (CubicSpline(*run)(late) for run in runs)
    size = abs(exact - device.beam.rise).max()
    return [abs(path - exact).max() / size for path in paths]


if __name__ == "__main__":
    main()

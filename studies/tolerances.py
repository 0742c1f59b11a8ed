"""Devices as made, for the handout's device: docs/devices.md.

./run python -m studies tolerances [--small]
"""

import time

import numpy as np

from snapmap import load_device
from snapmap.io.markdown import table
from snapmap.numerics.portable import geometric
from snapmap.sizing import design
from snapmap.tolerances.dataset import tolerance

from .common import ROOT, few

SCATTERS = {
    "thickness": 0.05,
    "rise": {"uniform": 0.2},
    "youngs_modulus": "5 %",
    "mass": "1 %",
    "spring": "3 %",
    "N": "2 %",
}
"""um, or shares; half a width where it is uniform."""
F0, C = [500.0, 1500.0, 5000.0, 15000.0], [25.0]
MANY, FREQUENCIES = 10_000, geometric(100, 3e4, 31)
THREADS = 2


def main():
    device = load_device(ROOT / "config" / "config.yaml")
    for line in (indices(device), distribution(device), cost(device), line_of_design(device)):
        print(line, end="\n\n")


def indices(device):
    """Total indices of each value, with their bounds."""
    made = tolerance(device, SCATTERS, few(F0), C, samples=few(1024, 16), threads=THREADS).squeeze(
        "C"
    )
    total, bounds = made.sensitivity, made.sensitivity_bound
    rows = []
    for value in made.value.values:
        at = {"value": value, "order": "total"}
        ends = bounds.sel(at).transpose("f0", "bound").values
        middle = total.sel(at).values
        cells = (f"{m:.2f} ({a:.2f} to {b:.2f})" for m, (a, b) in zip(middle, ends, strict=True))
        rows.append([str(value), *cells])
    return table(["value", *(f"{f0:g} Hz" for f0 in few(F0))], rows)


def distribution(device):
    """How thresholds scatter."""
    made = tolerance(
        device, SCATTERS, few(F0), C, samples=few(4096, 16), index_samples=16, threads=THREADS
    )
    made = made.squeeze("C")
    rows = []
    for f0 in few(F0):
        at = made.sel(f0=f0)
        low, high = (at.N_quantile.sel(quantile=share).item() for share in (0.01, 0.99))
        spread = at.N_std.item() / at.N_mean.item()
        values = at.N_nominal.item(), at.N_mean.item(), low, high
        nominal, mean, *ends = (f"{value:.0f}" for value in values)
        rows.append([f"{f0:g}", nominal, mean, f"{spread:.1%}", *ends])
    head = ["f0, Hz", "nominal", "mean", "standard deviation", "1 % snap at", "99 % snap at"]
    return table(head, rows)


def cost(device):
    """How long many devices take, kernels compiled."""
    asked = {"threads": THREADS, "index_samples": 16}
    tolerance(device, SCATTERS, F0[:1], C, samples=16, **asked)
    begun = time.perf_counter()
    tolerance(device, SCATTERS, few(FREQUENCIES), C, samples=few(MANY, 16), **asked)
    took = time.perf_counter() - begun
    cells = f"{few(MANY, 16)} devices x {few(FREQUENCIES).size} frequencies"
    return f"{cells}: {took:.0f} s in {THREADS} threads"


def line_of_design(device):
    """Which thickness a threshold of 1500 g at 1 ms asks for, over the rise."""
    rise = few(np.array([8.0, 9.0, 10.0, 11.0, 12.0]))
    asked = {"N": 1500.0, "f0": 1000.0, "C": 25.0, "between": (1.5, 3.2), "threads": THREADS}
    found = design(device, "thickness", rise=rise, **asked)
    rows = [
        [f"{at.rise.item():g}", f"{at.thickness.item():.4f}", f"{at.error.item():.4f}"]
        for at in (found.isel(rise=i) for i in range(rise.size))
    ]
    return table(["rise, um", "thickness, um", "error, um"], rows)


if __name__ == "__main__":
    main()

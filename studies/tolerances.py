"""The scatter of the handout's device as made, for docs/applications/tolerances.md.

./run python -m studies tolerances [--small]
"""

from snapmap import Study, tolerance

from .common import command_device, few
from .tables import Table, write

SCATTERS = {"thickness": 0.05, "rise": {"uniform": 0.2}, "youngs_modulus": "5 %"}
SCATTERS |= {"mass": "1 %", "spring": "3 %", "N": "2 %"}
"""Standard deviations, um or shares; half the width of a uniform distribution."""
F0, C = [500.0, 1500.0, 15000.0], [25.0]


def main():
    device = command_device()
    write("tolerances", indices(device), distribution(device))


def sampled(device, **options):
    """Find the thresholds of samples of the device, without the axis C."""
    return tolerance(Study(device), SCATTERS, few(F0), C, **options).squeeze("C")


def indices(device):
    """Make a table of the total index of each value, with its bounds."""
    batch = sampled(device, samples=few(1024, 16)).sel(order="total")
    rows = []
    for value in batch.value.values:
        ends = batch.sensitivity_bound.sel(value=value).transpose("f0", "bound").values
        middle = batch.sensitivity.sel(value=value).values
        cells = (f"{m:.2f} ({a:.2f} to {b:.2f})" for m, (a, b) in zip(middle, ends, strict=True))
        rows.append([str(value), *cells])
    return Table("tolerances_indices", ["value", *(f"{f0:g} Hz" for f0 in F0)], rows)


def distribution(device):
    """Make a table of mean, standard deviation and quantiles of thresholds."""
    batch = sampled(device, samples=few(4096, 16), index_samples=16)
    rows = []
    for f0 in few(F0):
        at = batch.sel(f0=f0)
        low, high = (at.N_quantile.sel(quantile=share).item() for share in (0.01, 0.99))
        spread = at.N_std.item() / at.N_mean.item()
        values = at.N_nominal.item(), at.N_mean.item(), low, high
        nominal, mean, *ends = (f"{value:.0f}" for value in values)
        rows.append([f"{f0:g}", nominal, mean, f"{spread:.1%}", *ends])
    head = ["f0, Hz", "nominal", "mean", "standard deviation", "1 % snap at", "99 % snap at"]
    return Table("tolerances_thresholds", head, rows)

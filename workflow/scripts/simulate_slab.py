"""Rule simulate_slab: follow the cells of one slab of the grid."""

from snapmap.device import device_from
from snapmap.slab import Slab, write_slab


def simulate_slab(device, model, axes, horizon, path, threads):
    """Simulate one slab and write it; values in internal units, axes as in the cube."""
    counts = write_slab(device_from(device), model, Slab(**axes), horizon, path, threads)
    print(f"slab {path}: {counts}")


if __name__ == "__main__":
    simulate_slab(
        device=snakemake.params.device,
        model=snakemake.params.model,
        axes=snakemake.params.axes,
        horizon=snakemake.params.horizon,
        path=snakemake.output.slab,
        threads=snakemake.threads,
    )

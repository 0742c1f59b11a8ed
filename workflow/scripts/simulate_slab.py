"""Rule simulate_slab: follow the cells of one slab of the grid."""

from snapmap.device import device_from
from snapmap.journal import journal
from snapmap.partition import Slab
from snapmap.protocol import Protocol
from snapmap.slab import write_slab


def simulate_slab(device, model, axes, protocol, path, threads, code):
    """Simulate one slab and write it; values in internal units, axes as in the cube."""
    cells, asked = Slab(**axes), Protocol(**protocol)
    counts = write_slab(device_from(device), model, cells, asked, path, threads, code)
    print(f"{path}: " + ", ".join(f"{n} {outcome}" for outcome, n in counts.items()))


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        simulate_slab(
            device=snakemake.params.device,
            model=snakemake.params.model,
            axes=snakemake.params.axes,
            protocol=snakemake.params.protocol,
            path=snakemake.output.slab,
            threads=snakemake.threads,
            code=snakemake.params.code,
        )

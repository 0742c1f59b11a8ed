"""Rule draw_integrity: draw distances to other labels, their erosion, and uncertain boxes."""

from itertools import product

import xarray as xr

from snapmap.figures import integrity, style
from snapmap.io.job_log import run_rule
from snapmap.numerics.portable import evenly

MOST = 2
"""Maps that are drawn, each by both kinds of label; of more some are, evenly chosen."""


def draw_integrity(integrity_path, stem):
    """Read the integrity of maps and draw it."""
    with xr.open_dataset(integrity_path, engine="netcdf4") as found, style.paper():
        others = [key for key in found.integrity.dims if key not in ("labels", "f0", "N")]
        every = list(product(*(range(found.sizes[key]) for key in others)))
        some = [dict(zip(others, every[place], strict=True)) for place in evenly(len(every), MOST)]
        places = [{"labels": label, **at} for at in some for label in range(found.labels.size)]
        style.save(integrity.draw_integrity(found, places), stem, found.attrs)


if __name__ == "__main__":
    run_rule(draw_integrity, snakemake)

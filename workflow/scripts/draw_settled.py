"""Rule draw_settled: draw the maps without and with damping of the beam side by side."""

import xarray as xr

from snapmap.figures import maps, style
from snapmap.io.job_log import run_rule


def draw_settled(settled_path, beam_dampings, C, stem):
    """Read the sweeps and draw the map of one C (uN us/um) for each beam damping (1/us)."""
    with xr.open_dataset(settled_path, engine="netcdf4") as settled, style.paper():
        figure = style.double_column(height=9)
        panels = [maps.Panel(settled.sel(damping=damping, C=C)) for damping in beam_dampings]
        maps.draw_maps(figure, panels, "f0", "N")
        style.save(figure, stem, settled.attrs)


if __name__ == "__main__":
    run_rule(draw_settled, snakemake)

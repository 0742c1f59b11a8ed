"""Rule draw_settled: draw the maps without and with damping of the beam side by side."""

import xarray as xr

from snapmap.figures import maps, style
from snapmap.journal import journal


def draw_settled(settled_path, beam_dampings, C, pdf_path, png_path):
    """Read the sweeps and draw the map of one C (uN us/um) for each beam damping (1/us)."""
    with xr.open_dataset(settled_path, engine="netcdf4") as settled, style.paper():
        figure = style.double_column(height=3.6)
        axes = figure.subplots(1, len(beam_dampings), sharey=True)
        for ax, damping in zip(axes, beam_dampings, strict=True):
            maps.draw_map(ax, settled.sel(beam_damping=damping, C=C))
            caption = ax.get_title(loc="left").splitlines()[-1]
            ax.set_title(f"{style.damping(C)}, beam damping {damping:g} µs$^{{-1}}$\n{caption}")
        axes[-1].set_ylabel("")
        style.save(figure, pdf_path, png_path, settled.attrs)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        draw_settled(
            settled_path=snakemake.input.settled,
            beam_dampings=snakemake.params.beam_dampings,
            C=snakemake.params.C,
            pdf_path=snakemake.output.pdf,
            png_path=snakemake.output.png,
        )

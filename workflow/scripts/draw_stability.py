"""Rule draw_stability: draw the verdicts on the hard cases."""

import xarray as xr

from snapmap.figures import stability, style
from snapmap.journal import journal


def draw_stability(stability_path, pdf_path, png_path):
    """Read the hard cases and draw a panel for each model, as wide as two columns."""
    with xr.open_dataset(stability_path, engine="netcdf4") as cases, style.paper():
        figure = style.double_column(height=7.6)
        stability.draw_panels(figure, cases)
        style.save(figure, pdf_path, png_path, cases.attrs)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        draw_stability(
            stability_path=snakemake.input.stability,
            pdf_path=snakemake.output.pdf,
            png_path=snakemake.output.png,
        )

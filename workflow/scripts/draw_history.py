"""Draw the time history of one cell."""

import json

import xarray as xr

from snapmap.device import Beam
from snapmap.figures import histories, style


def draw_history(history_path: str, pdf_path: str, png_path: str) -> None:
    """Read a history and draw deflection, mass, contact force and shock over time."""
    with xr.open_dataset(history_path, engine="netcdf4") as history, style.paper():
        device = json.loads(history.attrs["config"])["device"]
        figure = style.double_column(height=4.2)
        histories.draw_history(
            figure.subplots(3, sharex=True, height_ratios=[2, 1, 1]),
            history,
            second_equilibrium=Beam(**device["beam"]).second_equilibrium,
            gravity=device["gravity"],
        )
        style.save(figure, pdf_path, png_path, history.attrs)


if __name__ == "__main__":
    draw_history(
        history_path=snakemake.input.history,
        pdf_path=snakemake.output.pdf,
        png_path=snakemake.output.png,
    )

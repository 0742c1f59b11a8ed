"""Rule draw_tolerance: draw how probably devices snap, what that depends on, and the yield."""

import xarray as xr

from snapmap.figures import style, tolerances
from snapmap.io.job_log import run_rule
from snapmap.numerics.portable import evenly

DRAWN = {
    "probability": (tolerances.draw_probability, tolerances.probability_keys),
    "sensitivity": (tolerances.draw_sensitivity, tolerances.sensitivity_keys),
}
COLUMNS, MOST = 3, 12
"""Panels side by side, and in one figure; of more values some are drawn, evenly chosen."""


def draw_tolerance(tolerance_path, places, folder):
    """Draw for each place on the axes of names a panel for each C, and for each requirement.

    places: by the ending of the figures' names
    """
    with xr.open_dataset(tolerance_path, engine="netcdf4") as found, style.paper():
        for ending, at in places.items():
            here = found.isel({key: place for key, place in at.items() if key in found.dims})
            for name, (draw, keys) in DRAWN.items():
                panels = [here.isel(C=i) for i in evenly(here.C.size, MOST)]
                _draw(f"{folder}/{name}{ending}", panels, draw, keys(here), found.attrs)
            if "requirement" in found.dims:
                panels = [
                    here.isel(requirement=i, C=j)
                    for i in evenly(here.requirement.size, MOST)
                    for j in evenly(here.C.size, MOST // min(MOST, here.requirement.size))
                ]
                keys = tolerances.requirement_keys()
                draw = tolerances.draw_requirement
                _draw(f"{folder}/yield{ending}", panels, draw, keys, found.attrs)


def _draw(stem, panels, draw, keys, attributes):
    dampings = len({panel.C.item() for panel in panels})
    columns = dampings if dampings in (2, COLUMNS) else min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    figure = style.double_column(height=0.9 + 2.6 * rows)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax, panel in zip(axes, panels, strict=False):
        draw(ax, panel)
    for ax in axes[len(panels) :]:
        ax.remove()
    title = tolerances.batch_text(panels[0], attributes)
    figure.legend(handles=keys, loc="outside lower center", ncols=4, title=title)
    style.save(figure, stem, attributes)


if __name__ == "__main__":
    run_rule(draw_tolerance, snakemake)

"""Rule draw_tolerance: draw how probably devices snap, what that depends on, and the yield."""

import xarray as xr

from snapmap.figures import style, tolerances
from snapmap.io.job_log import run_rule
from snapmap.numerics.portable import evenly

DRAWN = {
    "probability": (tolerances.draw_probability, tolerances.probability_keys),
    "sensitivity": (tolerances.draw_sensitivity, tolerances.sensitivity_keys),
}
COLUMNS, MOST, LINES = 3, 12, 6
"""Panels side by side, and in one figure, and lines; of more values some are drawn, evenly."""
ROW = 2.6
"""Height of a row of panels, in."""


def draw_tolerance(tolerance_path, places, yields, folder):
    """Draw for each place on the axes of names a panel for each C, and for each requirement.

    places, yields: by the ending of the figures' names
    """
    with xr.open_dataset(tolerance_path, engine="netcdf4") as found, style.paper():
        for ending, at in places.items():
            here = found.isel(at)
            for name, (draw, keys) in DRAWN.items():
                panels = [here.isel(C=i) for i in evenly(here.C.size, MOST)]
                figure, _ = _draw(panels, draw)
                _save(figure, f"{folder}/{name}{ending}", keys(here), here, found.attrs)
        for ending, at in yields.items():
            here = found.isel(at)
            here = here.isel(C=evenly(here.C.size, LINES))
            _draw_yield(here, f"{folder}/yield{ending}", found.attrs)


def _draw_yield(found, stem, attributes):
    """What meets the requirements, and below it a panel for each."""
    panels = [
        found.isel(requirement=i, C=j)
        for i in evenly(found.requirement.size, MOST)
        for j in evenly(found.C.size, MOST // min(MOST, found.requirement.size))
    ]
    height = 0.5 + 0.17 * len(list(tolerances.each_share(found))) * found.C.size
    figure, whole = _draw(panels, tolerances.draw_requirement, height)
    tolerances.draw_yield(whole, found)
    _save(figure, stem, tolerances.requirement_keys(found), panels[0], attributes)


def _draw(panels, draw, above=0.0):
    """A figure of panels, and axes of their own above them if these have a height, in."""
    dampings = len({panel.C.item() for panel in panels})
    columns = dampings if dampings in (2, COLUMNS) else min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    figure = style.double_column(height=0.9 + ROW * rows + above)
    heights = [above] * bool(above) + [ROW] * rows
    grid = figure.add_gridspec(len(heights), columns, height_ratios=heights)
    for number, panel in enumerate(panels):
        row, column = divmod(number, columns)
        draw(figure.add_subplot(grid[row + bool(above), column]), panel)
    return figure, figure.add_subplot(grid[0, :]) if above else None


def _save(figure, stem, keys, found, attributes):
    title = tolerances.batch_text(found, attributes)
    figure.legend(handles=keys, loc="outside lower center", ncols=4, title=title)
    style.save(figure, stem, attributes)


if __name__ == "__main__":
    run_rule(draw_tolerance, snakemake)

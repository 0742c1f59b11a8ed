"""What the rules of figures run, each a function named like its rule: reads, draws, saves.

views: name, x, y, at, the place on each other axis, and of cells required_shocks
own_points: path and SHA-256 of a user's own points, or nothing
"""

from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path

import xarray as xr

from snapmap.figures import (
    accuracy,
    calibration,
    convergence,
    histories,
    layout,
    maps,
    requirements,
    scales,
    stability,
    statics,
    style,
    thresholds,
    tolerances,
)
from snapmap.io.atomic import replacing
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import check_alike
from snapmap.io.tables import read_points, read_verdicts
from snapmap.numerics.portable import evenly

COLUMNS, MOST, LINES = 3, 12, 6
"""Panels of devices as made side by side, and in a figure, and lines; of more, evenly chosen."""
ROW = 2.6
"""Height of a row of these panels, in."""


@contextmanager
def _drawing(path):
    with xr.open_dataset(path, engine="netcdf4") as found, style.paper():
        yield found


def draw_snap_maps(
    cube_path, threshold_path, views, together, fields, own_points, folder, traces_path=None
):
    """Draw which cells snap, with the thresholds, and some of it side by side; then thresholds.

    traces_path: with the stress of each cell, of devices that have a strength
    """
    own_points = read_points(*own_points) if own_points else ()
    with (
        _drawing(cube_path) as cube,
        xr.open_dataset(threshold_path, engine="netcdf4") as found,
        xr.open_dataset(traces_path) if traces_path else nullcontext() as traces,
    ):
        check_alike(cube, found, threshold_path)
        if traces is not None:
            check_alike(cube, traces, traces_path)
            share = traces.stress_max / traces.strength
            numbers = {key: cube[key] for key in share.dims if cube[key].dtype.kind == "f"}
            cube = cube.assign(stress_share=share.reindex(numbers, method="nearest"))
        for view in views:
            shown = view["required_shocks"], own_points
            _draw_map(maps.draw_snap_map, _panel(cube, found, view), view, folder, cube, *shown)
        if together:
            panels = [_panel(cube, found, view) for view in together]
            _draw_together(panels, together[0], own_points, f"{folder}/snap_maps", cube)
        for view in fields:
            lines = [_along(found, view)]
            _draw_map(thresholds.draw_threshold_map, lines, view, folder, found)


def draw_maps(cube_path, times, ends, together, own_points, folder):
    """Draw when beams snap; then where they end, and some of it side by side."""
    own_points = read_points(*own_points) if own_points else ()
    with _drawing(cube_path) as cube:
        # Of what is drawn: a cube may be larger than memory.
        colours = maps.snap_times(_along(cube, view) for view in times)
        for view in times:
            _draw_map(maps.draw_time_map, [_along(cube, view)], view, folder, cube, colours)
        for view in ends:
            shown = view["required_shocks"], own_points
            _draw_map(maps.draw_end_map, [_along(cube, view)], view, folder, cube, *shown)
        if together:
            panels = [maps.Panel(_along(cube, view)) for view in together]
            _draw_together(panels, together[0], own_points, f"{folder}/maps", cube)


def _along(found, view):
    at = {key: place for key, place in view["at"].items() if key in found.dims}
    return scales.along(found.isel(at), view["x"], view["y"])


def _panel(cube, found, view):
    return maps.Panel(_along(cube, view), _along(found, view))


def _draw_map(draw, data, view, folder, found, *shown):
    ax = layout.single_box()
    draw(ax, *data, view["x"], view["y"], *shown)
    layout.trim(ax.figure)
    style.save(ax.figure, f"{folder}/{view['name']}", found.attrs)


def _draw_together(panels, view, own_points, stem, found):
    figure = style.double_column(height=9)
    maps.draw_maps(figure, panels, view["x"], view["y"], own_points)
    style.save(figure, stem, found.attrs)


def draw_thresholds(threshold_path, views, boundary, folder):
    """Draw the thresholds over each axis, and as a damage boundary."""
    with _drawing(threshold_path) as found:
        for view in views:
            figure = style.double_column(height=3.4)
            thresholds.draw_thresholds(figure.subplots(), _along(found, view), view["x"], view["y"])
            style.save(figure, f"{folder}/{view['name']}", found.attrs)
        figure = style.single_column(height=3.2)
        lines = found.isel(boundary["at"])
        thresholds.draw_damage_boundary(figure.subplots(), lines, boundary["y"])
        style.save(figure, f"{folder}/{boundary['name']}", found.attrs)


def draw_histories(history_paths, stems):
    """Draw the time history of each cell that was followed in full."""
    for path, stem in zip(history_paths, stems, strict=True):
        with _drawing(path) as history:
            figure = style.double_column(height=4.2)
            axes = figure.subplots(3, sharex=True, height_ratios=[2, 1, 1])
            histories.draw_history(axes, history)
            style.save(figure, stem, history.attrs)


def draw_statics(statics_paths, stems):
    """Draw the force and the energy of each beam that was pushed slowly."""
    for path, stem in zip(statics_paths, stems, strict=True):
        with _drawing(path) as found:
            figure = style.single_column(height=3.6)
            force, energy = figure.subplots(2, sharex=True, height_ratios=[3, 2])
            statics.draw_force_displacement(force, found)
            statics.draw_energy(energy, found)
            force.label_outer()
            style.save(figure, stem, found.attrs)


def draw_requirements(requirements_path, stem):
    """Draw the margin of each required shock, a row for each device and C."""
    verdicts = read_verdicts(requirements_path)
    with style.paper():
        figure = style.double_column(height=1.2 + 0.32 * len(verdicts))
        requirements.draw_margins(figure.subplots(), verdicts)
        style.save(figure, stem, {"title": "Margins of required shocks"})


def draw_calibration(calibration_path, stem):
    """Draw measured shots over the fitted threshold and its band, by shape and direction."""
    with _drawing(calibration_path) as found:
        panels = calibration.panels(found)
        figure = style.double_column(height=3.4)
        axes = figure.subplots(1, len(panels), squeeze=False)[0]
        for ax, panel in zip(axes, panels, strict=True):
            calibration.draw_shots(ax, panel)
        keys, title = calibration.shot_keys(), calibration.calibration_text(found)
        figure.legend(handles=keys, loc="outside lower center", ncols=5, title=title)
        style.save(figure, stem, found.attrs)


def draw_tolerance(tolerance_path, places, yields, folder):
    """Draw how probably devices snap, and what that depends on, a panel for each C; and the yield.

    places, yields: on the axes of names, by the ending of the figures' names
    """
    drawn = {
        "probability": (tolerances.draw_probability, tolerances.probability_keys),
        "sensitivity": (tolerances.draw_sensitivity, tolerances.sensitivity_keys),
    }
    with _drawing(tolerance_path) as found:
        for ending, at in places.items():
            here = found.isel(at)
            panels = [here.isel(C=i) for i in evenly(here.C.size, MOST)]
            for name, (draw, keys) in drawn.items():
                figure, _ = _draw_panels(panels, draw)
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
    figure, above = _draw_panels(panels, tolerances.draw_requirement, height)
    tolerances.draw_yield(above, found)
    _save(figure, stem, tolerances.requirement_keys(found), panels[0], attributes)


def _draw_panels(panels, draw, above=0.0):
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


def draw_accuracy(accuracy_path, stem):
    """Draw error against time for every model."""
    with _drawing(accuracy_path) as found:
        figure = style.double_column(height=3.6)
        accuracy.draw_accuracy(figure.subplots(), found)
        style.save(figure, stem, found.attrs)


def draw_convergence(accuracy_path, stem):
    """Draw how the error of the threshold falls with number and step."""
    with _drawing(accuracy_path) as found:
        figure = style.double_column(height=3.2)
        axes = figure.subplots(1, 2, sharey=True, width_ratios=[3, 2])
        convergence.draw_convergence(axes, found)
        style.save(figure, stem, found.attrs)


def draw_stability(stability_path, stem):
    """Draw the verdicts on the hard cases, a panel for each model."""
    with _drawing(stability_path) as cases:
        figure = style.double_column(height=stability.height(cases))
        stability.draw_panels(figure, cases)
        style.save(figure, stem, cases.attrs)


def draw_settled(settled_path, beam_dampings, C, stem):
    """Draw the map of one C, uN us/um, for each beam damping, 1/us, side by side."""
    with _drawing(settled_path) as settled:
        figure = style.double_column(height=9)
        panels = [maps.Panel(settled.sel(damping=damping, C=C)) for damping in beam_dampings]
        maps.draw_maps(figure, panels, "f0", "N")
        style.save(figure, stem, settled.attrs)


def write_page(cube_path, traces_path, threshold_path, horizon, path, tolerance_path=None):
    """Write the page to explore a cube; horizon: us; tolerance_path: of devices as made."""
    from snapmap.figures.explore import page  # brings Plotly

    with ExitStack() as files:
        paths = cube_path, traces_path, threshold_path, *filter(None, [tolerance_path])
        cube, *others = (
            files.enter_context(xr.open_dataset(one, engine="netcdf4")) for one in paths
        )
        for other, one in zip(others, paths[1:], strict=True):
            check_alike(cube, other, one)
        traces, found, *made = others
        text = page(cube, traces, found, horizon, *made)
    with replacing(path) as temporary:
        Path(temporary).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    run_rule(globals()[snakemake.rule], snakemake)

"""What the rules of figures run, each a function named like its rule: reads, draws, saves.

views: name, x, y, at, the place on each other axis, and of cells required_shocks
own_points: path and SHA-256 of a user's own points, or nothing
"""

from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path

import xarray as xr

from snapmap.figures import (
    calibration,
    histories,
    maps,
    requirements,
    scales,
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
            data = _along(cube, view), _along(found, view)
            _draw_map(maps.draw_map, data, view, folder, cube, *shown)
        if together:
            panels = [(_along(cube, view), _along(found, view)) for view in together]
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
            data = _along(cube, view), None
            _draw_map(maps.draw_map, data, view, folder, cube, *shown, True)
        if together:
            panels = [(_along(cube, view), None) for view in together]
            _draw_together(panels, together[0], own_points, f"{folder}/maps", cube, True)


def _along(found, view):
    at = {key: place for key, place in view["at"].items() if key in found.dims}
    return scales.along(found.isel(at), view["x"], view["y"])


def _draw_map(draw, data, view, folder, found, *shown):
    figure = style.single_column(height=5)
    draw(figure.subplots(), *data, view["x"], view["y"], *shown)
    style.fit(figure, maps.RATIO)
    style.save(figure, f"{folder}/{view['name']}", found.attrs)


def _draw_together(panels, view, own_points, stem, found, ends=False):
    figure = style.double_column(height=9)
    maps.draw_maps(figure, panels, view["x"], view["y"], own_points, ends)
    style.save(figure, stem, found.attrs)


def draw_thresholds(threshold_path, views, boundary, folder):
    """Draw the thresholds over each axis, and as a damage boundary."""
    with _drawing(threshold_path) as found:
        for view in views:
            figure = style.double_column(height=3.4)
            thresholds.draw_thresholds(figure.subplots(), _along(found, view), view["x"], view["y"])
            style.save(figure, f"{folder}/{view['name']}", found.attrs)
        figure = style.single_column(height=3.6)
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
            style.legend(figure, style.labelled([force]), ncols=2)
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
        words = calibration.calibration_text(found)
        style.legend(figure, style.labelled(axes), words, 5)
        style.save(figure, stem, found.attrs)


def draw_tolerance(tolerance_path, places, yields, folder):
    """Draw how probably devices snap, and what that depends on, a panel for each C; and the yield.

    places, yields: on the axes of names, by the ending of the figures' names
    """
    drawn = {
        "probability": tolerances.draw_probability,
        "sensitivity": tolerances.draw_sensitivity,
    }
    with _drawing(tolerance_path) as found:
        for ending, at in places.items():
            here = found.isel(at)
            panels = [here.isel(C=i) for i in evenly(here.C.size, MOST)]
            for name, draw in drawn.items():
                figure, _ = _draw_panels(panels, draw)
                words = tolerances.batch_text(here, found.attrs)
                style.legend(figure, style.labelled(figure.axes), words)
                style.save(figure, f"{folder}/{name}{ending}", found.attrs)
        for ending, at in yields.items():
            here = found.isel(at)
            here = here.isel(C=evenly(here.C.size, LINES))
            panels = [
                here.isel(requirement=i, C=j)
                for i in evenly(here.requirement.size, MOST)
                for j in evenly(here.C.size, MOST // min(MOST, here.requirement.size))
            ]
            height = 0.5 + 0.17 * len(list(requirements.each_share(here))) * here.C.size
            figure, above = _draw_panels(panels, requirements.draw_requirement, height)
            requirements.draw_yield(above, here)
            words = tolerances.batch_text(panels[0], found.attrs)
            style.legend(figure, style.labelled(figure.axes), words)
            style.save(figure, f"{folder}/yield{ending}", found.attrs)


def _draw_panels(panels, draw, above=0.0):
    """A figure of panels, and axes above them if these have a height, in."""
    dampings = len({panel.C.item() for panel in panels})
    columns = dampings if dampings in (2, COLUMNS) else min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    figure = style.double_column(height=0.9 + ROW * rows + above)
    *upper, lower = figure.subfigures(
        1 + bool(above), height_ratios=[above] * bool(above) + [ROW * rows], squeeze=False
    ).flat
    axes = lower.subplots(rows, columns, squeeze=False).flat
    for ax, panel in zip(axes, panels, strict=False):
        draw(ax, panel)
    for ax in axes[len(panels) :]:
        ax.remove()
    return figure, upper[0].subplots() if upper else None


def draw_accuracy(accuracy_path, stem):
    """Draw error against time for every model."""
    from studies.accuracy.figures import draw_accuracy

    with _drawing(accuracy_path) as found:
        figure = style.double_column(height=3.6)
        draw_accuracy(figure.subplots(), found)
        style.save(figure, stem, found.attrs)


def draw_convergence(accuracy_path, stem):
    """Draw how the error of the threshold falls with number and step."""
    from studies.accuracy.figures import draw_convergence

    with _drawing(accuracy_path) as found:
        figure = style.double_column(height=3.2)
        draw_convergence(figure.subplots(1, 2, sharey=True, width_ratios=[3, 2]), found)
        style.save(figure, stem, found.attrs)


def draw_stability(stability_path, stem):
    """Draw the verdicts on the hard cases, a panel for each model."""
    from studies.stability.figures import draw_panels

    with _drawing(stability_path) as cases:
        figure = style.double_column(height=9)
        draw_panels(figure, cases)
        style.save(figure, stem, cases.attrs)


def draw_settled(settled_path, beam_dampings, C, stem):
    """Draw the map of one C, uN us/um, for each beam damping, 1/us, side by side."""
    with _drawing(settled_path) as settled:
        figure = style.double_column(height=9)
        panels = [(settled.sel(damping=damping, C=C), None) for damping in beam_dampings]
        maps.draw_maps(figure, panels, "f0", "N", ends=True)
        style.save(figure, stem, settled.attrs)


def write_page(cube_path, traces_path, threshold_path, horizon, path):
    """Write the page to explore a cube; horizon: us."""
    from snapmap.figures.explore import page  # brings Plotly

    paths = cube_path, traces_path, threshold_path
    with ExitStack() as files:
        cube, *others = (
            files.enter_context(xr.open_dataset(one, engine="netcdf4")) for one in paths
        )
        for other, one in zip(others, paths[1:], strict=True):
            check_alike(cube, other, one)
        text = page(cube, *others, horizon)
    with replacing(path) as temporary:
        Path(temporary).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    run_rule(globals()[snakemake.rule], snakemake)

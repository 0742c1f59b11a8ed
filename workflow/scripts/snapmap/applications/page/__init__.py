"""The page to explore a study in a browser.  Imports: histories."""

key = "traces"
rule, message, priority, megabytes = "trace_cells", "Trace the motion of the cells", 65, 2000
part, caption = "4 Page", "page"


def section():
    """Whether all cells are followed again."""
    from ...config.keys import flag

    return flag("whether all cells are followed again, to show how each moves", out="`false`")


def request(section, study, document):
    """Whether all cells are followed again: on request, or as the beam of one may break."""
    return bool(section) or study.has_strength


def threads(cores):
    """Half of the cores, so that other jobs go on beside."""
    return max(1, cores // 2)


def outputs(study):
    """The motion of all cells in brief."""
    return {"traces": "results/traces.nc"} if study.requests["page"] else {}


def inputs(study):
    """The cube."""
    return {"cube": "results/cube.nc"}


def params(study):
    """All settings of the study, as the cube has them."""
    return {"settings": study.inputs()}


def run(study, cube_path, path):
    """Follow the cells of the cube again."""
    from ...study.netcdf import open_whole, write_product
    from .traces import trace

    with open_whole(cube_path) as cube:
        traces = trace(study, cube)
        shares = f"{traces.bin_length.size} of {cube.outcome.size} cells"
    write_product(traces, path, lambda _: f"{shares} in {traces.sizes['bin']} time bins each")


def drawn_from(study):
    """Cube and thresholds, and the motion of the cells if there is one."""
    return {"cube": "results/cube.nc", "threshold": "results/threshold.nc"} | outputs(study)


def figures(study):
    """The page; its name is not that of a picture."""
    return {"explore.html": {"horizon": study.settings.horizon}}


def draw(figures, folder, cube_path, threshold_path, traces_path=""):
    """Write the page."""
    from contextlib import nullcontext

    from ...files.atomic import write_text
    from ...study.netcdf import check_alike, open_whole
    from .figure import page  # brings Plotly

    with (
        open_whole(cube_path) as cube,
        open_whole(threshold_path) as thresholds,
        open_whole(traces_path) if traces_path else nullcontext() as traces,
    ):
        check_alike(cube, thresholds, threshold_path)
        if traces_path:
            check_alike(cube, traces, traces_path)
        for name, horizon in figures.items():
            write_text(page(cube, traces, thresholds, **horizon), f"{folder}/{name}")

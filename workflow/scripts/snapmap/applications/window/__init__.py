"""Where on two axes required shocks are met.  Imports: requirements."""

from ..requirements import plain_shocks, shocks_of

rule, message = "find_window", "Find the window of the requirements"
part, threads, megabytes, priority = "5 Requirements", 4, 2000, 48


def outputs(study):
    """The window, of a study with required shocks and two axes of device and damper."""
    from .window import choose_axes

    is_drawn = shocks_of(study) and choose_axes(study.grid)
    return {"window": "results/window.nc"} if is_drawn else {}


def params(study):
    """The axes, required shocks, and what scatters."""
    from .window import DESIGN_AXES

    tolerances = study.requests.get("tolerances")
    return {
        "axes": {key: study.axes[key].tolist() for key in study.axes if key in DESIGN_AXES},
        "requirements": plain_shocks(study),
        "tolerances": tolerances._asdict() if tolerances else {},
    }


def run(study, path):
    """Find where required shocks are met, and by which share of devices."""
    from ...study.netcdf import write_product
    from .window import DESIGN_AXES, summary, window_of

    axes = {key: study.axes[key] for key in study.axes if key in DESIGN_AXES}
    tolerances = study.requests.get("tolerances")
    dataset = window_of(study.of_thresholds(), axes, shocks_of(study), tolerances)
    write_product(dataset, path, lambda window: summary(window, study.units))


def figures(study):
    """A figure over both axes, with their units."""
    from .window import choose_axes

    units = {key: study.units.get(key) for key in choose_axes(study.grid)}
    return {"window": {"axes": units}}


def draw(figures, folder, window_path):
    """Draw where all required shocks are met."""
    from ...figures import style
    from ...study.netcdf import open_whole
    from .figure import draw_window

    axes = figures["window"]["axes"]
    with (
        open_whole(window_path) as dataset,
        style.saved(f"{folder}/window", dataset.attrs, 4) as figure,
    ):
        draw_window(figure, dataset, *axes, axes)

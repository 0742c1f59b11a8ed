"""The damage boundary: thresholds over the velocity change.  Imports: core alone."""

quick = True
part = "2 Thresholds"


def drawn_from(study):
    """The thresholds."""
    return {"threshold": "results/threshold.nc"}


def figures(study):
    """A figure, unless a force pushes the beam: then the velocity of the frame does not change."""
    from ...config.devices import nominal
    from ...config.views import choose_boundary

    views = choose_boundary(study.grid, nominal(study.device))
    return {view.name: {"lines": view.y, "at": view.at} for view in views}


def draw(figures, folder, threshold_path):
    """Draw the damage boundary of each line."""
    from ...figures import style
    from ...study.netcdf import open_whole
    from .figure import draw_damage_boundary

    with open_whole(threshold_path) as thresholds:
        for stem, view in figures.items():
            with style.saved(f"{folder}/{stem}", thresholds.attrs, 3.6, columns=1) as figure:
                chosen = thresholds.isel(view["at"])
                draw_damage_boundary(figure.subplots(), chosen, view["lines"])

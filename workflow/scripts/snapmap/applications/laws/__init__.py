"""The map in three laws: dwell, snap time, velocity change.  Imports: core alone."""

rule, message = "find_laws", "Find where the three laws hold"
part = "2 Thresholds"


def section():
    """Whether the laws are compared with the thresholds."""
    from ...config.keys import flag

    return flag("whether three laws are fitted to the thresholds", out="`false`")


def request(section, study, document):
    """Whether the laws are compared with the thresholds."""
    return bool(section)


def outputs(study):
    """The laws beside the thresholds."""
    return {"laws": "results/laws.nc"} if study.requests["laws"] else {}


def inputs(study):
    """The thresholds."""
    return {"threshold": "results/threshold.nc"}


def params(study):
    """Nothing beside the thresholds."""
    return {}


def run(study, threshold_path, path):
    """Compare the laws with the thresholds of the first device and pulse."""
    from ...study.netcdf import open_whole, write_product
    from .laws import laws_of, summary

    with open_whole(threshold_path) as thresholds:
        write_product(laws_of(study.of_thresholds(), study.grid, thresholds), path, summary)


def figures(study):
    """A figure over f0."""
    return {"laws": {}}


def draw(figures, folder, laws_path):
    """Draw thresholds and laws."""
    from ...figures import style
    from ...study.netcdf import open_whole
    from .figure import draw_laws

    with open_whole(laws_path) as laws, style.saved(f"{folder}/laws", laws.attrs, 4.6) as figure:
        draw_laws(figure, laws)

"""Shocks that must or must not trip a device.  Imports: histories, design."""

rule, message = "check_requirements", "Check the required shocks"
part, caption, threads, priority = "5 Requirements", "requirements", 4, 50


def section():
    """A list of requirements of each kind that an application has."""
    from ...config.keys import many
    from .. import gather
    from .sections import requirement

    kinds = {key: kind for made in gather("kinds").values() for key, kind in made.items()}
    return many(requirement(kinds), "a list of shocks", out="none")


def described():
    """Its sections, as docs/config.md has them."""
    from .sections import ShockSection

    return {"each of requirements": ShockSection}


def request(sections, study, document):
    """The requirements, each by a name of its own, which the study can have."""
    from .reading import read_requirements

    return read_requirements(sections or (), study, document.pulse)


def shocks_of(study):
    """Required shocks of a study, as functions take them: name, shocks, N, f0 (Hz), snaps."""
    return [one.values for one in study.requests.get("requirements", ()) if "shocks" in one.values]


def plain_shocks(study):
    """The same in plain values."""
    required = study.requests.get("requirements", ())
    return [one.plain() for one in required if "shocks" in one.values]


def left_out(study):
    """Names of what a yield leaves out: all but required shocks, and their closing."""
    from ...study.study import CLOSING

    names = [one.values["name"] for one in study.requests.get("requirements", ())]
    shocks = shocks_of(study)
    names = [name for name in names if name not in [one["name"] for one in shocks]]
    closing = [one["name"] for one in shocks if any(key in one for key in CLOSING)]
    return names + [f"the closing of {name}" for name in closing]


def files(study):
    """Recorded shocks among the requirements."""
    pulses = [one["pulse"] for one in shocks_of(study)]
    return {one["file"]: one["sha256"] for one in pulses if "file" in one}


def marks(study):
    """Required shocks on maps: name, f0 (Hz), N, and under what each pushes."""
    from ...solver.settings import FIRST

    for required in shocks_of(study):
        start = required.get("start", FIRST)
        pushed = [(one.pulse.given, one.direction, start) for one in required["shocks"].each()]
        yield required["name"], required["f0"], required["N"], pushed


def outputs(study):
    """The table of verdicts."""
    asked = study.requests["requirements"]
    return {"requirements": "results/requirements.csv"} if asked else {}


def params(study):
    """Requirements, C, and the tolerance of thresholds."""
    return {
        "requirements": [one.plain() for one in study.requests["requirements"]],
        "C": study.axes["C"].tolist(),
        "temperatures": study.temperatures,
        "tolerance": study.threshold_tolerance,
    }


def run(study, path):
    """Judge what is required; write a row for each device, corner and C, with what it does."""
    from .table import write_verdicts

    write_verdicts(study.of_thresholds(), study.requests["requirements"], path)


def figures(study):
    """The margins of all requirements."""
    return {"requirements": {}}


def draw(figures, folder, requirements_path):
    """Draw the margin of each requirement, a row for each worst corner."""
    import xarray as xr

    from ...figures import style
    from ...files.tables import read_verdicts
    from .corners import corners
    from .figure import draw_margins

    verdicts = read_verdicts(requirements_path)
    about, height = xr.Dataset(attrs={"title": "Margins of required shocks"}), 1.2
    height += 0.32 * len(corners(verdicts))
    with style.saved(f"{folder}/requirements", about.attrs, height) as figure:
        draw_margins(figure.subplots(), verdicts)

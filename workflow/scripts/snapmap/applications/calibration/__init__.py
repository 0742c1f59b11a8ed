"""Values of a device estimated from measured shots.  Imports: core alone."""

public = {"calibrate": "dataset"}
rule, message = "fit_calibration", "Estimate values of the device from measured shots"
part, threads, priority = "6 Devices as made", 4, 45


def section():
    """Shots and unknowns of a config."""
    from ...config.keys import part
    from .sections import CalibrationSection

    return part(CalibrationSection, out="none")


def described():
    """Its sections, as docs/config.md has them."""
    from .sections import CalibrationSection, UnknownsSection

    return {"calibration": CalibrationSection, "calibration.unknowns": UnknownsSection}


def request(section, study, document):
    """The `Calibration`, or None; ValueError, one line, for an invalid section."""
    from .sections import read_calibration

    if not section:
        return None
    return read_calibration(section, study.device, study.shocks, study.axes["C"])


def files(study):
    """The table of shots, and the recorded shocks that it names."""
    return study.requests["calibration"].files if study.requests["calibration"] else {}


def refuse(study):
    """Raise ValueError, one line, for shots that no device of the ranges can give."""
    from .dataset import refuse_far

    if asked := study.requests["calibration"]:
        refuse_far(study.of_thresholds(), asked.shots, asked.unknowns, asked.C)


def outputs(study):
    """The estimates."""
    return {"calibration": "results/calibration.nc"} if study.requests["calibration"] else {}


def params(study):
    """Files with their SHA-256, unknowns and C."""
    return {"calibration": list(study.requests["calibration"][1:])}


def run(study, path):
    """Fit the unknowns to the shots."""
    from dataclasses import replace

    from ...study.netcdf import write_product
    from .dataset import calibration_of, summary

    shots, _, unknowns, C = study.requests["calibration"]
    of_shots = replace(study.of_thresholds(), shocks=study.shocks.first())
    write_product(calibration_of(of_shots, shots, unknowns, C), path, summary)


def figures(study):
    """A figure of all shots."""
    return {"calibration": {}}


def draw(figures, folder, calibration_path):
    """Draw shots over the fitted threshold and its band, by shape and direction."""
    from ...figures import style
    from ...study.netcdf import open_whole
    from .figure import draw_calibration

    with (
        open_whole(calibration_path) as dataset,
        style.saved(f"{folder}/calibration", dataset.attrs, 3.4) as figure,
    ):
        draw_calibration(figure, dataset)

"""The largest stress of each cell, where a beam may break.  Imports: core alone."""

rule, message, priority, megabytes = "find_stress", "Find the largest stress", 65, 2000


def threads(cores):
    """Half of the cores, so that other jobs go on beside."""
    return max(1, cores // 2)


def outputs(study):
    """The largest stress of each cell, if a device of the study has a strength."""
    return {"stress": "results/stress.nc"} if study.has_strength else {}


def inputs(study):
    """The cube."""
    return {"cube": "results/cube.nc"}


def params(study):
    """All settings of the study, as the cube has them."""
    return {"settings": study.inputs()}


def run(study, cube_path, path):
    """Follow the cells of the cube again."""
    from ...study.netcdf import open_whole, write_product
    from .stress import stress_of_cube

    with open_whole(cube_path) as cube:
        stress = stress_of_cube(study, cube)
        shares = f"{stress.stress_max.size} of {cube.outcome.size} cells"
    write_product(stress, path, lambda _: f"{shares} followed for the largest stress")

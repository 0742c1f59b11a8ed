"""The files that a run of a study makes, and whether they are whole."""

from PIL import Image

from snapmap.applications import gather
from snapmap.applications.requirements.verdict import read_verdicts
from snapmap.study.variables import open_whole
from snapmap.workflow.made import LIST
from snapmap.workflow.plan import choose_views


def products(study):
    """The names of all products of a study in results."""
    files = {"cube.nc", "threshold.nc", "thresholds.csv"}
    made = gather(lambda part: part.outputs(study))
    for paths in (paths for outputs in made.values() for paths in outputs.values()):
        listed = [paths] if isinstance(paths, str) else paths
        files |= {path.removeprefix("results/") for path in listed}
    drawn = {name for stems in choose_views(study).stems.values() for name in stems}
    for folder, figures in gather(lambda part: part.figures(study)).items():
        if folder in made or folder == "boundary":
            drawn |= {*figures}
    files |= {f"figures/{name}.{ending}" for name in drawn for ending in ("png", "pdf")}
    return files | {"explore.html"}


def assert_whole(folder, study):
    """A run in a folder has made the products of a study, and no others, and each opens."""
    results = folder / "results"
    made = {path.relative_to(results).as_posix() for path in results.rglob("*.*")}
    made = {name for name in made if not name.startswith(("logs/", "slabs/", LIST))}
    assert made == products(study)
    for name in made:
        open_product(results / name)


def open_product(path):
    """Open a product; a file that is not whole is a fault."""
    if path.suffix == ".nc":
        with open_whole(path) as dataset:
            assert dataset.attrs["config"]
    elif path.suffix == ".png":
        with Image.open(path) as image:
            image.verify()
    elif path.suffix == ".pdf":
        assert path.read_bytes()[:5] == b"%PDF-"
        assert path.read_bytes().rstrip().endswith(b"%%EOF")
    elif path.name == "requirements.csv":
        assert read_verdicts(path)
    else:
        assert path.stat().st_size > 0

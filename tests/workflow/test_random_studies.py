"""Studies of combined features, made at random, run whole or are refused before the first job."""

import re

import pytest
import yaml
from PIL import Image
from random_studies import FILES, products, random_study
from small_workflow import snakemake

from snapmap.applications.requirements.corners import read_verdicts
from snapmap.config.study import load_config
from snapmap.study.netcdf import open_whole
from snapmap.workflow.made import LIST

SEEDS = range(10)


def run(root, folder, text):
    """Run a study whole and open its products, or see it refused in lines; tells whether it ran."""
    for name, content in FILES.items():
        (folder / name).write_text(content)
    (config := folder / "mine.yaml").write_text(text)
    code, output = snakemake(root, folder, config, check=False)
    assert "Traceback" not in output, output
    if code != 0:
        assert not (folder / "results").exists(), output
        return False
    results = folder / "results"
    made = {path.relative_to(results).as_posix() for path in results.rglob("*.*")}
    apart = re.compile(rf"logs/|slabs/|{LIST}$")
    assert {name for name in made if not apart.match(name)} == products(
        load_config(yaml.safe_load(text))
    )
    for path in (results / name for name in made if not apart.match(name)):
        open_product(path)
    return True


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

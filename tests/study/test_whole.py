"""Products that are not as they were written: refused by name, by whoever opens them."""

import inspect
import os
import re

import draw
import numpy as np
import pytest
import xarray as xr
import yaml
from small_studies import TINY

from snapmap.applications import attached
from snapmap.applications.whole import load_config
from snapmap.study.variables import open_whole, write


@pytest.fixture
def product(tmp_path):
    path = tmp_path / "product.nc"
    write(xr.Dataset({"N_first": ("f0", np.arange(40.0))}, {"f0": np.arange(40.0)}), path)
    return path


@pytest.mark.filterwarnings("error")
def test_a_product_of_another_has_its_own_dimensions(tmp_path):
    """An empty dimension of a file comes back as an unlimited one."""
    edges = xr.Dataset({"N": ("f0", [1.0]), "island": (("f0", "i"), np.empty((1, 0)))})
    write(edges, tmp_path / "threshold.nc")
    with open_whole(tmp_path / "threshold.nc") as opened:
        assert opened.encoding["unlimited_dims"] == {"i"}
        write(opened[["N"]], tmp_path / "laws.nc")


def test_a_flipped_or_cut_file_is_named(product):
    whole = product.read_bytes()
    with open_whole(product) as opened:
        assert opened.N_first.values.tolist() == list(range(40))
    places = range(0, len(whole), 61)
    flips = (whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :] for at in places)
    line = rf"^{re.escape(str(product))}: is damaged; remove it and run again$"
    for damaged in (*flips, whole[:-1], whole[: len(whole) // 2], b""):
        product.write_bytes(damaged)
        with pytest.raises(ValueError, match=line):
            open_whole(product)


APPLICATIONS = attached()
READERS = {draw.draw_study: ("cube", "threshold"), APPLICATIONS["stress"].run: ()}
READERS[APPLICATIONS["page"].draw] = "cube", "threshold"
READERS |= {APPLICATIONS[key].draw: (key,) for key in ("window", "calibration", "statics")}
READERS[APPLICATIONS["tolerances"].draw] = ("tolerance",)
"""Functions of jobs, and the names of the files that those of figures read."""


@pytest.mark.parametrize("reader", READERS)
def test_every_job_names_a_damaged_product(product, tmp_path, reader):
    product.write_bytes(product.read_bytes()[:-500])
    given = {"views": {"own_points": ()}, "figures": {"any": {}}, "cube_path": product}
    given |= {"files": dict.fromkeys(READERS[reader], str(product))}
    given |= dict.fromkeys(("path", "folder"), tmp_path / "made")
    arguments = {name: given.get(name, ()) for name in inspect.signature(reader).parameters}
    with pytest.raises(ValueError, match=r"^/.*product\.nc: is damaged"):
        reader(**arguments)
    assert [*tmp_path.iterdir()] == [product]


def test_verdicts_on_a_full_disk_are_named(tmp_path, monkeypatch):
    text = TINY + "requirements: [{name: crash, N: 2000, f0: 2 kHz, snaps: true}]"

    def replace(*_):
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(OSError, match=r"requirements\.csv: not written, .* MB are free there"):
        study = load_config(yaml.safe_load(text))
        APPLICATIONS["requirements"].run(study, tmp_path / "requirements.csv")
    assert not [*tmp_path.iterdir()]

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

from snapmap.applications import (
    calibration,
    page,
    requirements,
    statics,
    stress,
    tolerances,
    window,
)
from snapmap.config.study import load_config
from snapmap.study.netcdf import open_whole, write


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


FIGURES = {"window": {"axes": {}}, "explore": {"horizon": 0}}
READERS = dict.fromkeys(
    [draw.draw_study, page.application.draw, stress.application.run, window.application.draw],
    FIGURES,
)
READERS |= {
    calibration.application.draw: FIGURES,
    statics.application.draw: {"statics": {}},
    tolerances.application.draw: FIGURES,
}


@pytest.mark.parametrize("reader", READERS)
def test_every_job_names_a_damaged_product(product, tmp_path, reader):
    product.write_bytes(product.read_bytes()[:-500])
    names = inspect.signature(reader).parameters
    arguments = {name: product if name.endswith("_path") else () for name in names}
    arguments |= {name: [product] for name in names if name.endswith("_paths")}
    arguments |= {name: tmp_path / "made" for name in ("path", "folder") if name in names}
    arguments |= {"figures": READERS[reader]} if "figures" in names else {}
    with pytest.raises(ValueError, match=r"^/.*product\.nc: is damaged"):
        reader(**arguments)
    assert [*tmp_path.iterdir()] == [product]


def test_verdicts_on_a_full_disk_are_named(tmp_path, monkeypatch):
    text = TINY + "requirements: [{name: crash, N: 2000, f0: 2 kHz, snaps: true}]"

    def replace(*_):
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(OSError, match=r"requirements\.csv: not written, .* MB are free there"):
        requirements.application.run(
            load_config(yaml.safe_load(text)), tmp_path / "requirements.csv"
        )
    assert not [*tmp_path.iterdir()]

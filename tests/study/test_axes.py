"""Any value of the device as an axis: each slice is what that device gives alone, bit for bit."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import yaml
from small_studies import TINY
from varied import varied

import snapmap
from snapmap.config.study import load_config
from snapmap.device.device import VALUES
from snapmap.sweeps.collect import collect_slabs
from snapmap.sweeps.slabs import slab_name, write_slab
from snapmap.workflow.plan import make_plan

SHOCK = {"N": [700.0, 900.0, 1100.0, 1300.0], "f0": [900.0, 4000.0], "C": [0.5, 30.0]}
MODELS = {
    "elements": {"model": "elements", "elements": 3},
    "cosines": {"model": "cosines", "modes": 3},
    "auto": {"model": "auto"},
    "reference": {"model": "reference", "elements": 2, "until": "snap"},
}


def same(one, other):
    return all(one[key].values.tobytes() == other[key].values.tobytes() for key in other.data_vars)


@pytest.mark.parametrize("model", MODELS)
def test_a_slice_of_a_sweep_is_the_sweep_of_its_device(handout, model):
    asked = SHOCK | {"horizon": 200.0, "threads": 2} | MODELS[model]
    axes = {"spring": [5.0, 6.5], "thickness": [1.9, 2.1]}
    cube = snapmap.sweep(handout, **asked, **axes)
    assert cube.outcome.dims == ("spring", "thickness", "C", "f0", "N")
    for spring, thickness in itertools.product(*axes.values()):
        alone = snapmap.sweep(varied(handout, spring=spring, thickness=thickness), **asked)
        assert same(cube.sel(spring=spring, thickness=thickness), alone)


@pytest.mark.parametrize("key", VALUES)
def test_every_value_can_be_an_axis(handout, key):
    handout = varied(handout, free=1.0, imperfection=0.01) if key == "imperfection" else handout
    nominal = getattr(handout.beam, key, None) or getattr(handout, key, None) or 1e-3
    values = [*dict.fromkeys((1.01 * nominal, 0.99 * nominal))]
    asked = {"model": "cosines", "modes": 3, "until": "snap", "horizon": 100.0}
    one_row = {"N": SHOCK["N"], "f0": [1500.0], "C": [25.0]}
    cube = snapmap.sweep(handout, **one_row, **asked, **{key: values})
    assert cube[key].values.tolist() == values and cube[key].attrs["units"]
    for i, value in enumerate(values):
        alone = snapmap.sweep(varied(handout, **{key: value}), **one_row, **asked)
        assert same(cube.isel({key: i}), alone)


def test_devices_by_name_are_an_axis(handout):
    devices = {"as drawn": handout, "thin": varied(handout, thickness=1.8, mass=9e3)}
    asked = SHOCK | {"horizon": 100.0, "model": "cosines", "modes": 3}
    cube = snapmap.sweep(devices, **asked, spring=[5.0, 6.0])
    assert cube.outcome.dims == ("device", "spring", "C", "f0", "N")
    for name, device in devices.items():
        alone = snapmap.sweep(device, **asked, spring=[5.0, 6.0])
        assert same(cube.sel(device=name), alone)
    found = snapmap.threshold(devices, [1500.0], [25.0], model="cosines")
    alone = [snapmap.threshold(one, [1500.0], [25.0], model="cosines") for one in devices.values()]
    assert found.N_first.values.ravel().tolist() == [one.N_first.item() for one in alone]
    assert found.N_static.values.tolist() == [one.N_static.item() for one in alone]


def document(**sweep):
    whole = yaml.safe_load(TINY)
    whole["sweep"] |= sweep
    return whole


def test_a_study_names_the_point_that_cannot_be():
    with pytest.raises(ValueError, match=r"^sweep: thickness = 4 um: device.beam: "):
        load_config(document(thickness=["1.9 um", "4 um"]))
    study = load_config(document(thickness=["1.9 um", "4 um"], not_bistable="skip"))
    assert study.grid.device_of.tolist() == [0, -1]


def test_slabs_of_many_axes_make_the_cube_of_one_sweep(tmp_path, monkeypatch):
    monkeypatch.setattr("snapmap.workflow.plan.JOB_SECONDS", 2e-4)
    whole = document(thickness=["1.8 um", "1.9 um", "4 um"], not_bistable="skip")
    whole |= {"model": {"name": "cosines", "modes": 3}}
    study = load_config(whole)
    slabs = make_plan(study.grid, study.model, study.settings).slabs
    assert len(slabs) > 4 and sum(np.prod([len(v) for v in s.values()]) for s in slabs) == 96
    paths = [tmp_path / f"{slab_name(study, slab)}.nc" for slab in slabs]
    for slab, path in zip(slabs, paths, strict=True):
        write_slab(replace(study, skip=True), slab, path)
    cube = collect_slabs(paths, study.axes, whole)
    axes = {key: values for key, values in study.axes.items()}
    in_one = snapmap.sweep(study.device, **axes, model="cosines", modes=3, horizon=200.0, skip=True)
    assert set(cube.variables) == set(in_one.variables)
    assert same(cube, in_one)
    counts = [key for key in in_one.attrs if key.startswith(("cells_", "share_"))]
    assert [cube.attrs[key] for key in counts] == [in_one.attrs[key] for key in counts]

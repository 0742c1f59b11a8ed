"""Any value of the device as an axis: each slice is what that device gives alone, bit for bit."""

import itertools
import math
from dataclasses import replace

import pytest
import yaml
from small_results import assert_same_cube
from small_studies import TINY
from varied import varied

import snapmap
from snapmap import Study
from snapmap.applications.whole import load_config
from snapmap.config.views import frequency_of
from snapmap.device.device import VALUES
from snapmap.solver.outcome import ABSENT
from snapmap.study.axes import duration_of
from snapmap.sweeps.cube import collect_slabs
from snapmap.sweeps.slabs import slab_name, write_slab
from snapmap.workflow.plan import make_plan

SHOCK = {"N": [700.0, 900.0, 1100.0, 1300.0], "f0": [900.0, 4000.0], "C": [0.5, 30.0]}
CHEAP = {"model": "3 cosines", "horizon": 100.0}
MODELS = {name: {"model": f"3 {name}"} for name in ("elements", "cosines")}
MODELS["auto"] = {"model": "auto"}
MODELS["reference"] = {"model": snapmap.Reference(elements=2), "until": "snap"}


def same(cube, other):
    return all(cube[key].values.tobytes() == other[key].values.tobytes() for key in cube.data_vars)


@pytest.mark.parametrize("key", VALUES)
def test_every_value_can_be_an_axis(handout, key):
    handout = varied(handout, free=1.0, imperfection=0.01) if key == "imperfection" else handout
    nominal = getattr(handout.beam, key, None) or getattr(handout, key, None) or 1e-3
    values = [*dict.fromkeys((1.01 * nominal, 0.99 * nominal))]
    how = {"until": "snap", **CHEAP}
    asked = {"N": SHOCK["N"], "f0": [1500.0], "C": [25.0]}
    cube = snapmap.sweep(Study(handout, **how), **asked, axes={key: values})
    assert cube[key].values.tolist() == values and cube[key].attrs["units"]
    for i, value in enumerate(values):
        one = snapmap.sweep(Study(varied(handout, **{key: value}), **how), **asked)
        assert same(cube.isel({key: i}), one)


DEVICES = {"as drawn": {}, "thin": {"thickness": 1.8, "mass": 9e3}}


@pytest.mark.parametrize("model", MODELS)
def test_devices_by_name_their_values_shapes_and_directions_are_axes(handout, model):
    devices = {name: varied(handout, **values) for name, values in DEVICES.items()}
    how = {"horizon": 200.0, "threads": 2} | MODELS[model]
    shapes, axes = ["half sine", "sawtooth"], {"spring": [5.0, 6.5]}
    study = Study(devices, pulse=shapes, direction="both", **how)
    cube = snapmap.sweep(study, **SHOCK, axes=axes)
    assert cube.outcome.dims == ("device", "spring", "shape", "direction", "C", "f0", "N")
    each = itertools.product(devices, axes["spring"], shapes, ["+z", "-z"])
    for name, spring, shape, way in each:
        device = varied(devices[name], spring=spring)
        alone = snapmap.sweep(Study(device, pulse=shape, direction=way, **how), **SHOCK)
        assert same(cube.sel(device=name, spring=spring, shape=shape, direction=way), alone)


def document(**sweep):
    whole = yaml.safe_load(TINY)
    whole["sweep"] |= sweep
    return whole


def test_a_study_names_the_point_that_cannot_be():
    with pytest.raises(ValueError, match=r"^sweep: thickness = 4 um: device.beam: "):
        load_config(document(thickness=["1.9 um", "4 um"]))
    study = load_config(document(thickness=["1.9 um", "4 um"]) | {"skip": True})
    assert study.grid.device_of.tolist() == [0, -1]
    alone = Study({"thick": varied(study.device, thickness=4.0)}, skip=True, **CHEAP)
    assert (snapmap.sweep(alone, **SHOCK).outcome == ABSENT).all()


def test_slabs_of_many_axes_make_the_cube_of_one_sweep(tmp_path, monkeypatch):
    monkeypatch.setattr("snapmap.workflow.plan.JOB_SECONDS", 1e-3)
    whole = document(thickness=["1.8 um", "1.9 um", "4 um"]) | {"skip": True}
    whole |= {"model": {"name": "cosines", "modes": 3}}
    study = load_config(whole)
    slabs = make_plan(study).slabs
    sizes = [math.prod(map(len, slab.values())) for slab in slabs]
    assert len(slabs) > 4 and sum(sizes) == 96
    paths = [tmp_path / f"{slab_name(study, slab)}.nc" for slab in slabs]
    for slab, path in zip(slabs, paths, strict=True):
        write_slab(replace(study, skip=True), slab, path)
    cube = collect_slabs(paths, study.axes, whole)
    asked = Study(study.device, "3 cosines", horizon=200.0, skip=True)
    axes = dict(study.axes)
    shock = {key: axes.pop(key) for key in SHOCK}
    assert_same_cube(cube, snapmap.sweep(asked, **shock, axes=axes))


def test_a_duration_comes_back_from_the_f0_that_it_became():
    durations = [tenths / 10 for tenths in range(1, 300)]
    assert [duration_of(frequency_of(1e3 * duration)) for duration in durations] == durations

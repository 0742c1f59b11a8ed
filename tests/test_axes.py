"""Any value of the device as an axis: each slice is what that device gives alone, bit for bit."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import yaml
from small_studies import TINY

import snapmap
from snapmap.axes import make_grid
from snapmap.config.study import load_config
from snapmap.device import VALUES
from snapmap.solver.outcome import ABSENT
from snapmap.sweeps.collect import collect_slabs
from snapmap.sweeps.grid import follow_rows
from snapmap.sweeps.plan import make_plan
from snapmap.sweeps.slabs import slab_name, write_slab

SHOCK = {"N": [700.0, 900.0, 1100.0, 1300.0], "f0": [900.0, 4000.0], "C": [0.5, 30.0]}
MODELS = {
    "handout": {"model": "handout", "elements": 3},
    "cosines": {"model": "cosines", "modes": 3},
    "auto": {"model": "auto"},
    "reference": {"model": "reference", "elements": 2, "until": "snap"},
}


def varied(device, **values):
    """A device of which some values are others."""
    of_beam = {key: values.pop(key) for key in list(values) if hasattr(device.beam, key)}
    return replace(device, beam=replace(device.beam, **of_beam), **values)


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


def test_hard_contact_stands_beside_stiffnesses(handout):
    asked = SHOCK | {"horizon": 100.0, "model": "cosines", "modes": 3}
    cube = snapmap.sweep(handout, **asked, contact=[40.0, np.inf, 60.0])
    for contact in (40.0, np.inf, 60.0):
        assert same(
            cube.sel(contact=contact), snapmap.sweep(replace(handout, contact=contact), **asked)
        )


def test_elements_keep_modes_by_the_contact_of_all_devices(handout):
    hard = SHOCK | {"model": "handout", "contact": [40.0, np.inf]}
    with pytest.raises(ValueError, match="contact: the handout model takes hard ones and others"):
        snapmap.sweep(handout, **hard)


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


def test_a_device_without_a_second_shape_is_refused_by_name(handout):
    with pytest.raises(ValueError, match=r"^thickness = 4.5 um: device.beam: rise/thickness = "):
        snapmap.sweep(handout, **SHOCK, thickness=[2.0, 4.5, 5.0])


def test_a_device_without_a_second_shape_is_marked_if_asked(handout):
    asked = SHOCK | {"model": "cosines", "modes": 3, "horizon": 100.0, "skip": True}
    cube = snapmap.sweep(handout, **asked, thickness=[2.0, 4.5])
    assert (cube.outcome.sel(thickness=4.5) == ABSENT).all()
    assert cube.t_snap.sel(thickness=4.5).isnull().all()
    assert cube.outcome.attrs["flag_meanings"].split()[-1] == "absent"
    assert cube.attrs["cells_absent"] == cube.outcome[0].size
    alone = snapmap.sweep(handout, **asked)
    assert same(cube.sel(thickness=2.0), alone)
    shares = [key for key in alone.attrs if key.startswith("share_")]
    assert [cube.attrs[key] for key in shares] == [alone.attrs[key] for key in shares]
    found = snapmap.threshold(
        handout, [1500.0], [25.0], model="cosines", skip=True, thickness=[2.0, 4.5]
    )
    assert np.isfinite(found.N_first.values.ravel()).tolist() == [True, False]
    assert np.isfinite(found.N_static.values).tolist() == [True, False]


@pytest.mark.parametrize(
    ("wrong", "start"),
    [
        ({"thickness": []}, "thickness: [] is not a number or several"),
        ({"thickness": "2 um"}, "thickness: '2 um' is not a number or several"),
        ({"spring": [5.0, -1.0]}, "spring: [5.0, -1.0] is not a number or several"),
        ({"colour": [1.0]}, "colour: is no option of sweep"),
    ],
)
def test_a_wrong_axis_is_one_line(handout, wrong, start):
    with pytest.raises(ValueError) as fault:
        snapmap.sweep(handout, **SHOCK, **wrong)
    assert str(fault.value).startswith(start) and "\n" not in str(fault.value)


def test_devices_with_other_units_of_N_are_refused(handout):
    with pytest.raises(ValueError, match=r"^devices: gravity differs"):
        make_grid({"here": handout, "there": replace(handout, gravity=1.62e-6)}, SHOCK)


def document(**sweep):
    whole = yaml.safe_load(TINY)
    whole["sweep"] |= sweep
    return whole


def test_a_study_has_its_axes_in_the_order_of_the_config():
    study = load_config(document(spring=["4 N/m", "3 N/m"], thickness=["1.8 um", "1.9 um"]))
    assert list(study.axes) == ["spring", "thickness", "C", "f0", "N"]
    assert study.axes["spring"].tolist() == [3.0, 4.0]
    contact = load_config(document(contact=["hard", "40 N/m"])).axes["contact"]
    assert contact.tolist() == [40.0, np.inf]


def test_a_study_names_the_point_that_cannot_be():
    for skip in ({}, {"not_bistable": "refuse"}):
        with pytest.raises(
            ValueError, match=r"^sweep: thickness = 4 um: device.beam: .* 8 um/4 um"
        ):
            load_config(document(thickness=["1.9 um", "4 um"], **skip))
    with pytest.raises(ValueError, match=r"^sweep: no device has a second stable shape"):
        load_config(document(thickness=["4 um", "5 um"], not_bistable="skip"))
    study = load_config(document(thickness=["1.9 um", "4 um"], not_bistable="skip"))
    assert study.grid.device_of.tolist() == [0, -1]


def test_slabs_of_many_axes_make_the_cube_of_one_sweep(tmp_path, monkeypatch):
    monkeypatch.setattr("snapmap.sweeps.plan.JOB_SECONDS", 2e-4)
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


def test_an_axis_of_the_device_grows_as_any_other(tmp_path, monkeypatch):
    followed = []

    def counted(model, rows, N, settings):
        followed.append(rows.f0.size * len(N))
        return follow_rows(model, rows, N, settings)

    monkeypatch.setattr("snapmap.sweeps.slabs.follow_rows", counted)
    for thickness in (["1.8 um", "1.9 um"], ["1.8 um", "1.85 um", "1.9 um"]):
        followed.clear()
        study = load_config(document(thickness=thickness) | {"model": {"name": "cosines"}})
        for slab in make_plan(study.grid, study.model, study.settings).slabs:
            path = tmp_path / f"{slab_name(study, slab)}.nc"
            write_slab(study, slab, path)
    assert sum(followed) == study.grid.axes["C"].size * 2 * 8


def test_default_maps_are_N_over_f0_for_all_else():
    study = load_config(document(spring=["3 N/m", "4 N/m"]))
    assert [view.name for view in study.maps] == [
        "map_spring3_C0.5",
        "map_spring3_C30",
        "map_spring4_C0.5",
        "map_spring4_C30",
    ]
    assert {(view.x, view.y) for view in study.maps} == {("f0", "N")} and not study.left_out
    assert [(view.x, view.y) for view in study.curves] == [("f0", "C"), ("spring", "C")]


def test_of_too_many_maps_some_are_drawn_and_the_rest_is_told():
    many = {"from": "3 N/m", "to": "5 N/m", "points": 50}
    study = load_config(document(spring=many))
    assert len(study.maps) == 24
    assert study.left_out.startswith("maps: 24 of 100 are drawn, evenly chosen over spring, C; ")


def test_a_grid_without_a_plane_of_N_and_f0_is_drawn_over_what_varies():
    one = {"f0": ["1 kHz"], "N": [1000], "C": ["25 uN*us/um"]}
    two = {"thickness": ["1.8 um", "1.9 um"], "spring": ["3 N/m", "4 N/m"]}
    study = load_config(document(**one, **two))
    (only,) = study.maps
    assert (only.x, only.y, set(only.at)) == ("thickness", "spring", {"C", "f0"})


def test_a_map_is_asked_for_by_axes_and_the_nearest_values():
    whole = document(thickness=["1.8 um", "1.9 um"])
    whole["maps"] = [{"x": "thickness", "y": "N", "at": {"f0": "1.9 kHz", "C": "1 uN*us/um"}}]
    (view,) = load_config(whole).maps
    assert view.at == {"C": 0, "f0": 1}
    assert view.name == "map_thickness_N_C0.5_f02000"


@pytest.mark.parametrize(
    ("section", "view", "start"),
    [
        ("maps", {"x": "span", "y": "N"}, "maps[0].x: span is no axis of this sweep"),
        ("maps", {"x": "N", "y": "N"}, "maps[0]: x and y are the same axis"),
        ("maps", {"x": "f0", "y": "N", "at": {"C": "3 kg"}}, "maps[0].at.C: '3 kg' does not"),
        (
            "maps",
            {"x": "f0", "y": "N", "at": {"N": 3}},
            "maps[0].at.N: is no axis of this sweep, or",
        ),
        ("maps", {"x": "f0"}, "maps[0].y: missing"),
        ("thresholds", {"x": "N", "lines": "C"}, "thresholds[0].x: 'N' is not the name of an axis"),
    ],
)
def test_a_view_that_cannot_be_is_one_line(section, view, start):
    whole = document()
    whole[section] = [view]
    with pytest.raises(ValueError) as fault:
        load_config(whole)
    (line,) = str(fault.value).splitlines()
    assert line.startswith(start)


def test_devices_in_a_config_stand_beside_no_other():
    whole = document()
    one = whole.pop("device")
    whole["devices"] = {"a": one, "b": {**one, "spring": "5 N/m"}}
    study = load_config(whole)
    assert study.axes["device"].tolist() == ["a", "b"]
    with pytest.raises(ValueError, match=r"^devices: stand beside device"):
        load_config(whole | {"device": one})
    broken = {**one, "spring": "-1 N/m"}
    with pytest.raises(ValueError, match=r"^devices.b.spring: '-1 N/m' is not above 0"):
        load_config(whole | {"devices": {"a": one, "b": broken}})


def test_a_history_may_change_the_device():
    whole = document()
    cell = {"N": 1000, "duration": "1 ms", "C": "30 uN*us/um", "thickness": "2 um"}
    whole["histories"] = [cell]
    (history,) = load_config(whole).histories
    assert history.name == "N1000_f1000_C30_thickness2"
    assert history.device == varied(load_config(document()).device, thickness=2.0)


def test_maps_are_called_by_what_they_show():
    whole = document(thickness=["1.8 um", "1.9 um"])
    whole["maps"] = [{"x": "f0", "y": "N"}, {"x": "thickness", "y": "C"}]
    cells, thresholds = load_config(whole).maps
    assert cells.is_of_cells and not thresholds.is_of_cells
    assert cells.called("snap").name == cells.name.replace("map", "snap", 1)
    assert cells.called("snap")._replace(name=cells.name) == cells


def test_two_maps_of_the_same_values_are_one():
    whole = document()
    whole["maps"] = [{"x": "f0", "y": "N"}, {"x": "f0", "y": "N", "at": {"C": "29 uN*us/um"}}]
    assert [view.name for view in load_config(whole).maps] == ["map_f0_N_C30"]


@pytest.mark.parametrize(
    ("change", "start"),
    [
        (
            {"contact": {"from": "40 N/m", "to": "hard", "points": 3}},
            "sweep.contact: hard is no end",
        ),
        ({"contact": ["hard", "hard"]}, "sweep.contact: inf uN/um comes twice"),
        (
            {
                "spring": {"from": "3 N/m", "to": "4 N/m", "points": 1000},
                "mass": {"from": "1 ug", "to": "2 ug", "points": 1000},
            },
            "sweep: 1e+06 points of the device's axes, more than 100000",
        ),
    ],
)
def test_an_axis_that_is_a_slip_is_one_line(change, start):
    with pytest.raises(ValueError) as fault:
        load_config(document(**change))
    assert str(fault.value).startswith(start) and "\n" not in str(fault.value)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"thickness": "7 um"}, "device.beam: rise/thickness = 8 um/7 um"),
        ({"device": "a"}, "device is for studies of several devices"),
    ],
)
def test_a_history_that_cannot_be_is_named(change, complaint):
    whole = document()
    whole["histories"] = [{"N": 1000, "f0": "1 kHz", "C": "1 uN*us/um", **change}]
    with pytest.raises(ValueError, match=rf"^histories\[0\]: {complaint}"):
        load_config(whole)

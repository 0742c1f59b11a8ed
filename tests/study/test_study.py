"""A study, its axes and required shocks: what they refuse, keep and tell."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from varied import alone, varied

import snapmap
from snapmap import Study
from snapmap.device.device import batch
from snapmap.study import axes
from snapmap.study.provenance import device_sections
from snapmap.study.shock import SURVIVES, Demand, Requirement, Shock
from snapmap.study.study import SNAPS
from snapmap.study.variables import dress, flags, variables, write

DROP = {"drop": {"height": 1e6, "duration": 500.0}}
MOST = {"spring": np.arange(1.0, 1001), "depth": np.arange(1.0, 102)}
REFUSED = {
    "devices: gravity differs; write one value, as N counts": lambda device: axes.make_grid(
        {"a": device, "b": replace(device, gravity=1e-5)}, {}
    ),
    "spring: needs a mass; leave": lambda device: axes.make_grid(alone(device), {"spring": [5.0]}),
    r"axes.*: 1\.01e\+05 points, more than 100000;": lambda device: axes.make_grid(device, MOST),
    "device = b, depth = -1 um: depth: ": lambda device: axes.make_grid(
        {"b": device}, {"depth": [20.0, -1.0]}
    ),
    "device.force: a train shakes the frame; write gravity": lambda device: Study(
        alone(device, 1.0)
    ).require_frame("a train"),
    "device.force: the shock 'drop' shakes": lambda device: Study(alone(device, 1.0), pulse=DROP),
    "requirements: crash: pulse: missing, as the study's": lambda device: Requirement(
        **ASKED, f0=1e3
    ).under(Study(device, pulse=DROP).shocks),
    "f0: missing; write": lambda _: Requirement(**ASKED),
    "duration: excludes": lambda _: Requirement(**ASKED, f0=1.0, duration=1.0),
    "N: missing; write a number above 0$": lambda _: Requirement(name="a", snaps=True, f0=1.0),
    r"survives: 1\.0 is not": lambda _: Requirement(**ASKED, f0=1.0, survives=1.0),
}
ASKED = {"name": "crash", "N": 2000.0, "snaps": True}


@pytest.mark.parametrize("line", REFUSED)
def test_what_no_study_has_is_refused_in_a_line(handout, line):
    with pytest.raises(ValueError, match=f"^{line}"):
        REFUSED[line](handout)


def test_devices_of_a_study_are_single(handout):
    several = batch([handout])
    for wrong in (several, {}, {"a": several}, handout.beam, varied(handout, rise=np.ones(2))):
        with pytest.raises(ValueError, match="is not a Device of single values, or several"):
            Study(wrong)


def test_a_part_of_a_study_has_the_names_that_are_kept(handout):
    named = {"a": handout, "b": varied(handout, rise=9.0)}
    study = Study(named, pulse=["half sine", "sawtooth"], direction="both", until="snap")
    part = study.part({"device": ["b"], "shape": ["sawtooth"], "direction": ["-z"]})
    pulse = {"shape": ["sawtooth"], "direction": ("-z",)}
    assert part.device == {"b": named["b"]} and part.shocks.section() == {"pulse": pulse}
    assert study.part({"shape": ["half sine", "sawtooth"], "direction": ["+z", "-z"]}) == study
    assert [*study.devices()] == ["a", "b"] and Study(handout).devices() == {"device": handout}
    assert study.document(["until"])["run"] == {"until": "snap"} != study.document()["run"]


def test_the_time_of_a_shock_is_its_own_a_duration_or_f0(handout):
    drop = Study(handout, pulse=DROP)
    assert drop.set_out({"f0": None}).axes["f0"] == [1e6 / drop.pulse.duration]
    assert axes.frequencies(1500.0, None) == 1500.0 and axes.frequencies(None, 500.0) == 2000.0
    assert axes.frequencies(None, [500.0, 1000.0]).tolist() == [2000.0, 1000.0]
    assert axes.axis_behind("duration") == "f0" and axes.axis_behind("C") == "C"


def test_axes_tell_their_units_points_and_shared_values():
    assert axes.attributes_of("C", "kg")["units"] == "kg" and axes.attributes_of("none") == {}
    assert axes.attributes_of("f0")["units"] == "Hz" and "units" not in axes.attributes_of("device")
    point = {"device": "a", "depth": 20.0, "C": 25.0, "N": 900.0}
    assert axes.point_text(point) == "device = a, depth = 20 um, C = 25 uN*us/um, N = 900"
    ours = {"N": np.array([1.0, 2, 3]), "C": np.array([5.0])}
    mine, theirs = axes.shared_points(ours, {"N": [3.0, 9, 2], "C": [5.0]})
    assert [*map(list, mine)] == [[1, 2], [0]] and [*map(list, theirs)] == [[2, 0], [0]]


def test_a_required_shock_is_that_of_the_study_or_its_own(handout):
    study = Study(handout, pulse="sawtooth", direction="-z")
    made = Requirement(**ASKED, duration="0.5 ms").under(study.shocks, "second")
    assert (made.f0, made.N, made.start) == (2000.0, 2000.0, "second")
    assert (made.survives, made.share) == (SURVIVES, 0.0)
    assert made.shocks.section() == study.shocks.section()
    assert made.shaken(study) == study.but(start="second")
    own = {"pulse": "half sine", "direction": "+z", "start": "first", "survives": False}
    demand = ASKED | own | {"f0": 1e3, "share": "99 %", "confidence": "90 %"}
    other = Requirement(**demand).under(study.shocks, "second")
    assert (other.f0, other.start, other.survives) == (1e3, "first", 0.0)
    assert (other.share, other.confidence) == (0.99, 0.9)
    assert other.shocks.section() == Study(handout, pulse="half sine").shocks.section()
    drop = Study(handout, pulse=DROP).shocks
    demand = Demand(name="crash", snaps="any").shock(Shock, drop, 7.0)
    assert (demand.N, demand.f0, demand.snaps) == (7.0, drop.own_frequency(), "any")
    assert Requirement(**ASKED, f0=1e3, pulse="half sine").under(drop).f0 == 1e3


def test_a_device_is_written_with_what_differs_from_its_defaults(handout):
    hot = replace(handout, temperature=85.0, contact=np.inf)
    section = device_sections(hot)["device"]
    assert section["temperature"] == "85.0 degC" and section["contact"] == "hard"
    assert "temperature" not in device_sections(handout)["device"]
    section = device_sections(alone(handout, force=1.0))["device"]
    assert section["mass"] == "none" and section["force"] == "1.0 uN" and "gravity" not in section


def test_products_have_attributes_and_codes_have_words(tmp_path):
    codes = xr.DataArray([1, 0], dims="N", attrs=flags(["never", "snapped"]))
    assert snapmap.words(codes).values.tolist() == ["snapped", "never"]
    with pytest.raises(ValueError, match="is not a variable with flag_meanings, such as"):
        snapmap.words(codes.drop_attrs())
    must = variables("window")["must_snap"]["flag_meanings"].split()
    needs = {False: "must_not", True: "must_stay", "any": "may", "arrives": "must_arrive"}
    assert {snaps: must[code] for snaps, code in SNAPS.items()} == needs
    made = xr.Dataset({"t_snap": ("C", [1.0], {"units": "ms"})}, {"C": [1.0]})
    dressed = dress("cube", made, {"model": {"unit_of_C": "uN"}}, extra="1")
    assert dressed.t_snap.attrs["units"] == "ms" and "arrival" in dressed.t_snap.long_name
    assert dressed.C.attrs["units"] == "uN" and dressed.attrs["extra"] == "1" and dressed.title
    write(dressed.chunk(C=1), tmp_path / "cube.nc")
    with xr.open_dataset(tmp_path / "cube.nc") as file:
        kept = file.t_snap.encoding
        assert kept["zlib"] and kept["shuffle"] and kept["fletcher32"] and kept["complevel"] == 1
        assert kept["chunksizes"] == (1,) and "_FillValue" not in file.C.encoding

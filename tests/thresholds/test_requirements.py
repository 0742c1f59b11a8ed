"""Shocks of a config: shapes, records, directions; and those that must or must not trip."""

import copy
from dataclasses import replace

import numpy as np
import pytest
import yaml

import snapmap
from snapmap.axes import make_grid
from snapmap.beam.stress import break_probability
from snapmap.config.devices import read_device
from snapmap.config.doubts import descriptions, doubts
from snapmap.config.products import products
from snapmap.config.study import load_config
from snapmap.config.yaml_file import ConfigError
from snapmap.io.provenance import device_sections
from snapmap.pulse import make_pulse
from snapmap.shocks import make_shocks
from snapmap.solver.settings import Settings
from snapmap.study import Study
from snapmap.thresholds.requirements import Verdict, check, judge, summary, worst

SETTINGS = Settings(horizon=300.0)


@pytest.fixture
def document(root):
    return yaml.safe_load((root / "config" / "config.yaml").read_text(encoding="utf-8"))


def faults(document, **changes):
    with pytest.raises(ConfigError) as fault:
        load_config(copy.deepcopy(document) | changes)
    return str(fault.value)


def test_shapes_and_directions_are_axes_of_a_study(document):
    asked = {"shape": ["half sine", "trapezoid"], "rise": "20 %", "direction": "both"}
    study = load_config(document | {"pulse": asked})
    assert [*study.axes][-5:] == ["shape", "direction", "C", "f0", "N"]
    half, back, trapezoid, _ = study.grid.pulses
    assert half.name == "half sine" and back.area == -half.area
    assert trapezoid.area == pytest.approx(1 - (0.2 + 0.1) / 2)
    assert {view.y for view in study.curves} == {"shape", "direction"}
    drawn = [(view.y, view.at["C"]) for view in study.curves if view.y == "direction"]
    assert drawn == [("direction", place) for place in range(study.axes["C"].size)]
    plain = load_config(document)
    assert plain.pulse == {} and "shape" not in plain.axes


def test_a_record_keeps_its_own_duration_or_takes_another(document, root, monkeypatch):
    monkeypatch.chdir(root)
    sweep = {key: document["sweep"][key] for key in document["sweep"] if key != "f0"}
    study = load_config(document | {"pulse": {"file": "config/half_sine.csv"}, "sweep": sweep})
    assert study.axes["f0"].tolist() == [2000.0]
    assert "half_sine: shock response (quality factor 10)" in descriptions(study)[1]
    study = load_config(document | {"pulse": {"file": "config/half_sine.csv"}})
    assert study.axes["f0"].size == document["sweep"]["f0"]["points"]
    assert any("coarse for a period" in line for line in doubts(study)) is False
    assert "sweep.f0: missing" in faults(document, sweep=sweep)


@pytest.mark.parametrize(
    ("pulse", "wanted"),
    [
        ({"shape": "square"}, "pulse.shape: 'square' is not one of versed sine"),
        ({"shape": []}, "pulse.shape: "),
        ({"shape": ["half sine", "half sine"]}, "pulse.shape: "),
        ({"direction": "up"}, "pulse.direction: 'up' is not one of +z"),
        ({"shape": "half sine", "rise": "10 %"}, "pulse.rise: is of a trapezoid alone"),
        ({"shape": "trapezoid", "rise": "70 %", "fall": "40 %"}, "pulse.rise: with fall is more"),
        ({"file": "none.csv"}, "pulse.file: none.csv: is not there"),
        ({"file": "../shock.csv"}, "pulse.file: ../shock.csv lies outside the study's folder"),
        ({"file": "/etc/hostname"}, "pulse.file: /etc/hostname lies outside the study's folder"),
        ({"file": "a.csv", "shape": "half sine"}, "pulse.shape: stands beside file"),
        ({"form": "half sine"}, "pulse.form: unknown key"),
    ],
)
def test_a_pulse_that_cannot_be_is_named_in_one_line(document, pulse, wanted):
    told = faults(document, pulse=pulse)
    assert told.startswith(wanted) and "\n" not in told


@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        ({"N": -3}, "requirements[0].N: -3 is not above 0"),
        ({"duration": "1 ms"}, "requirements[0].duration: is one over f0"),
        ({"shape": "step"}, "requirements[0].shape: 'step' is not one of"),
        ({"direction": "both"}, "requirements[0].direction: 'both' is not one of"),
        ({"snaps": "yes"}, "requirements[0].snaps: "),
        *(
            ({"name": n}, f"requirements[0].name: {n!r} is not a name")
            for n in ("a|b", "a\n", "=a")
        ),
        ({"survives": "100 %"}, "requirements[0].survives: '100 %' is not between 0 % and 100 %"),
        ({"survives": 1}, "requirements[0].survives: 1 has no unit; write a share"),
        ({"file": "no.csv"}, "requirements[0].file: no.csv: is not there"),
    ],
)
def test_a_requirement_that_cannot_be_is_named_in_one_line(document, change, wanted):
    asked = {"name": "drop", "N": 500, "f0": "1 kHz", "snaps": False} | change
    told = faults(document, requirements=[asked])
    assert told.startswith(wanted) and "\n" not in told


def test_names_of_requirements_are_written_once(document):
    asked = {"name": "drop", "N": 500, "duration": "1 ms", "snaps": False}
    study = load_config(document | {"requirements": [asked]})
    assert study.requirements[0]["f0"] == 1000.0 and study.requirements[0]["pulse"] == {}
    assert "'drop' comes twice" in faults(document, requirements=[asked, asked])


@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        (
            {"srs": [["1 kHz", "100 m"], ["2 kHz", "1 g"]]},
            "srs[0][1]: '100 m' is no level; write one",
        ),
        (
            {"srs": [["2 kHz", "1 g"], ["1 kHz", "1 g"]]},
            "srs: [[2000.0, 1.0], [1000.0, 1.0]] is not two pairs",
        ),
        ({"N": 100}, "N: stands beside srs; leave it out"),
        ({"psd": [["1 kHz", "1 g^2/Hz"], ["2 kHz", "1 g^2/Hz"]]}, "srs: stands beside psd"),
    ],
)
def test_a_required_spectrum_is_read_or_its_fault_named_in_one_line(document, change, wanted):
    levels = [["100 Hz", "100 g"], ["1 kHz", "1500 g"]]
    asked = {"name": "crash", "srs": levels, "snaps": False, "direction": "-z"}
    study = load_config(document | {"requirements": [asked]})
    (found,) = study.all_required
    assert study.spectra == [found] and "requirements" in products(study).stems
    assert found["srs"] == [[100.0, 100.0], [1000.0, 1500.0]]
    assert (found["name"], found["direction"], found["snaps"]) == ("crash", "-z", False)
    told = faults(document, requirements=[asked | change])
    assert told.startswith(f"requirements[0].{wanted}") and "\n" not in told


def test_verdicts_follow_from_the_threshold_of_the_required_pulse(handout):
    record = replace(make_pulse("half sine"), peak=100 * handout.gravity)  # of a record of 100 g
    found = snapmap.threshold(handout, [2000.0], [25.0], pulse=record, horizon=300.0)
    first, error = found.N_first.item(), found.N_error.item()
    assert found.scale_first.item() == pytest.approx(first / 100)
    amounts = {"below": 0.99 * first, "at": first, "above": 1.01 * first}
    asked = [
        {
            "name": f"{name} {must}",
            "shocks": make_shocks(record),
            "N": N,
            "f0": 2000.0,
            "snaps": must,
        }
        for name, N in amounts.items()
        for must in (True, False)
    ]
    verdicts = check(Study(device=handout, settings=SETTINGS), asked, [25.0])
    expected = ["failed", "met", "unclear", "unclear", "met", "failed"]
    assert [one.verdict for one in verdicts] == expected
    for one, N in zip(verdicts, np.repeat([*amounts.values()], 2), strict=True):
        assert one.N_first == first and one.N_error == error
        assert one.margin == pytest.approx(first / N)
        assert (one.scale, one.scale_first) == pytest.approx((N / 100, first / 100))
        assert one.duration == 0.5 and one.shape == "half sine" and one.direction == "+z"
    told = summary(verdicts)
    assert told.startswith("2 of 6 requirements met; failed: below True, above False; unclear: at")
    one, words = worst(verdicts)
    off = {one.requirement: abs(np.log(one.margin)) for one in verdicts if one.verdict == "failed"}
    assert off[one.requirement] == max(off.values())
    assert ("not sensitive enough, trips" if one.must_snap else "too sensitive, trips") in words


def test_a_requirement_fails_if_the_beam_breaks(handout):
    blank = dict.fromkeys(Verdict._fields) | {"verdict": "met"}
    told, brittle = Verdict(**blank), replace(handout, strength=1500.0)
    for stress, must, verdict in ((1499, 0.999, "met"), (1501, 0.999, "failed"), (1501, 0, "met")):
        found, survival = judge(told, brittle, float(stress), must)
        assert found.verdict == verdict
        assert survival == (must, pytest.approx(1500 / stress), float(stress > 1500))
    found, survival = judge(told, handout, 9e9, 0.999)
    assert found.verdict == "met" and np.isnan(survival.strength_margin)
    scattered = replace(brittle, strength_modulus=2.0, strength_threshold=1000.0)
    verdicts = [
        judge(told, scattered, stress, 0.9)[0].verdict for stress in (900.0, 1400.0, 1600.0)
    ]
    assert verdicts == ["met", "met", "failed"]  # exp(-(1400 - 1000)^2/1500^2) = 0.931


def test_a_config_has_a_strength_and_its_recipe_too(document):
    def read(strength):
        return load_config(document | {"device": document["device"] | {"strength": strength}})

    weibull = {"scale": "3 GPa", "modulus": 10, "threshold": "1.446 GPa"}
    for given, kept in (("1.5 GPa", (1500, np.inf, 0)), (weibull, (3000, 10, 1446))):
        device = read(given).device
        found = device.strength, device.strength_modulus, device.strength_threshold
        assert found == kept
        written = device_sections(device)["device"]
        assert read_device(written) == device
        assert break_probability(device, np.array(kept[2])) == 0
    assert written["strength"]["modulus"] == "10.0"
    assert break_probability(device, np.array(4446.0)) == pytest.approx(1 - np.exp(-1))
    assert "strength" not in device_sections(load_config(document).device)["device"]
    for given in ("1.5", "-1 GPa", {"scale": "3 GPa"}, {"scale": "3 m", "modulus": 10}, 3):
        with pytest.raises(ConfigError, match=r"^device.strength[^\n]*$"):
            read(given)


def test_grids_know_their_pulses(handout):
    axes = {"C": [25.0], "f0": [1500.0], "N": [900.0]}
    assert [one.name for one in make_grid(handout, axes).pulses] == ["versed sine"]

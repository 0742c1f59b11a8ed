"""Keys of version 0.3 mean what they meant, and a line tells the key of today."""

import pytest
import yaml
from small_studies import MISSING, THREE_COSINES, changed, faults

from snapmap.config.devices import load_device
from snapmap.config.doubts import doubts
from snapmap.config.renamed import OF_DEVICE, OF_SWEEP
from snapmap.config.study import load_config

SWEEP = "sweep: {N: [900, 1000], f0: [1500 Hz], C: [25 uN*us/um]}"
TODAY = yaml.safe_load(THREE_COSINES + SWEEP)
TODAY["device"]["beam"]["imperfection"] = "0.01 um"
TODAY["device"]["beam"]["free"] = True
PAIRS = {
    "device.beam.guide": ("free", "device.beam.free", True),
    "device.beam.clamp.axial": ("20 kN/m", "device.beam.clamp_axial", "20 kN/m"),
    "device.stops.toward": ("19 um", "device.stop_toward", "19 um"),
    "device.stops.away": ("3 um", "device.stop_away", "3 um"),
    "device.stops.restitution": (0.7, "device.restitution", 0.7),
    "device.thermal.reference": ("25 degC", "device.reference_temperature", "25 degC"),
    "device.thermal.modulus": ("-63e-6 /K", "device.modulus_slope", "-63e-6 /K"),
    "device.thermal.mismatch": ("2e-7 /K", "device.expansion_mismatch", "2e-7 /K"),
    "device.thermal.damping": (0.7, "device.damper_exponent", 0.7),
    "device.strength.scale": ("2 GPa", "device.strength", "2 GPa"),
    "device.strength.modulus": (10, "device.strength_modulus", 10),
    "device.strength.threshold": ("1 GPa", "device.strength_threshold", "1 GPa"),
    "sweep.horizon": ("0.5 ms", "run.horizon", "0.5 ms"),
    "sweep.until": ("snap", "run.until", "snap"),
    "sweep.repeat": (True, "run.repeat", True),
    "sweep.energy_tolerance": (0.002, "run.energy_tolerance", 0.002),
    "sweep.start": ("first", "run.start", "first"),
    "sweep.not_bistable": ("skip", "skip", True),
}
"""A value under each old key, then today's key and value."""


def put(document, values):
    """Put values at paths such as device.stops.toward, in sections that may be new."""
    for path, value in values.items():
        *parents, last = path.split(".")
        section = document
        for key in parents:
            section = section.setdefault(key, {})
        section[last] = value
    return document


def old(*keys):
    """Today's study with old keys in place of those that it has."""
    document = changed(
        TODAY, **{"device__beam__free": MISSING} if "device.beam.guide" in keys else {}
    )
    return put(document, {key: PAIRS[key][0] for key in keys})


def today(*keys):
    return put(changed(TODAY), {PAIRS[key][1]: PAIRS[key][2] for key in keys})


def same(one, other):
    """Two studies are of the same device, model, run and shock."""
    return one.document() == other.document() and one.skip == other.skip


def told(keys):
    now = {key: PAIRS[key][1] for key in keys}
    now |= {key: f"{now[key]}: true" for key in keys if PAIRS[key][0] in ("free", "skip")}
    return {f"{key}: is called {now[key]} since version 0.4; write that" for key in keys}


def test_all_old_keys_are_known_here():
    assert {f"device.{key}" for key in OF_DEVICE} | {*OF_SWEEP} == {*PAIRS}


@pytest.mark.parametrize("keys", [*((key,) for key in PAIRS), (*PAIRS,)], ids=len)
def test_an_old_key_means_that_of_today_and_one_line_tells_it(keys):
    study, expected = load_config(old(*keys)), load_config(today(*keys))
    assert same(study, expected) and study.source == expected.source
    assert {*study.renamed} == told(keys) and len(study.renamed) == len(keys)
    assert doubts(study)[: len(keys)] == study.renamed and expected.renamed == []
    if any(key.startswith("device") for key in keys):
        assert study.device == load_device(old(*keys)["device"]) == expected.device


BESIDE = {key: key for key in PAIRS} | {
    **{key: key.rpartition(".")[0] for key in PAIRS if key.count(".") > 1},
    "device.beam.guide": "device.beam.guide",
}
"""The key that has a fault where an old one stands beside that of today."""
del BESIDE["device.strength.scale"]  # whose place is that of today's


@pytest.mark.parametrize("key", BESIDE)
def test_an_old_key_beside_that_of_today_is_unknown(key):
    (line,) = faults(put(old(key), {PAIRS[key][1]: PAIRS[key][2]}))
    of_strength = "device.strength: a mapping of 'modulus'", "device.strength: a mapping of 'thresh"
    assert line.startswith((f"{BESIDE[key]}: unknown key", *of_strength))


def test_old_keys_of_several_devices_are_told_for_each():
    """Also where YAML's aliases make their sections one."""
    one = old("device.stops.away")["device"]
    devices = {"one": one, "two": one | {"spring": "5 N/m"}}
    study = load_config(changed(TODAY, device=MISSING) | {"devices": devices})
    assert [device.stop_away for device in study.devices().values()] == [3.0, 3.0]
    assert [line.split(": ")[0] for line in study.renamed] == [
        *("devices.one.stops.away", "devices.two.stops.away")
    ]


def test_old_words_mean_what_they_meant_and_others_are_faults():
    guided = changed(TODAY, device__beam__imperfection="0 um", device__beam__free=MISSING)
    assert not load_config(put(guided, {"device.beam.guide": "guided"})).device.beam.free
    assert not load_config(put(changed(TODAY), {"sweep.not_bistable": "refuse"})).skip
    for key, wrong in (("device.beam.guide", "sideways"), ("sweep.not_bistable", [])):
        document = changed(TODAY, device__beam__free=MISSING)
        lines = faults(put(document, {key: wrong}))
        assert any(line.startswith(f"{PAIRS[key][1]}: ") for line in lines)


def test_a_tolerance_in_percent_is_a_plain_number_today():
    study = load_config(changed(TODAY, model={"name": "auto", "tolerance": "0.2 %"}))
    assert study.model.tolerance == 0.002
    (line,) = study.renamed
    assert line.startswith("model.tolerance: is a plain number since version 0.4; write 0.002")
    for wrong in ("0 %", "150 %", "a %"):
        (line,) = faults(changed(TODAY, model={"name": "auto", "tolerance": wrong}))
        assert line.startswith(f"model.tolerance: {wrong!r} is not a plain number")

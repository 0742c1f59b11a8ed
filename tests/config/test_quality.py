"""Quality factors: what a config gives is what a free decay measures; frequencies likewise."""

import copy
import math
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import yaml
from small_studies import THREE_COSINES

import snapmap
from snapmap.beam.elements import hermite_elements
from snapmap.beam.modal import natural_frequency
from snapmap.config.devices import read_device
from snapmap.config.doubts import doubts
from snapmap.config.study import load_config
from snapmap.config.vibrations import vibrations
from snapmap.config.yaml_file import ConfigError
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.models import build_model
from snapmap.solver.plain_loop import follow, nodal_system
from snapmap.solver.settings import MOVE

SWEEP = "sweep: {N: [900, 1000], f0: [1500 Hz], horizon: 100 us}"
DOCUMENT = yaml.safe_load(THREE_COSINES + SWEEP)
DOCUMENT["device"] |= {"gap": "5 um", "quality_factor": 94}
DOCUMENT["device"]["beam"]["quality_factor"] = 60
BEAMS = [{}, {"rise": "5 um"}, {"residual_stress": "-40 MPa"}]
BEAMS += [{"residual_stress": "20 MPa", "rise": "12 um"}]
BEAMS += [{"guide": "free", "imperfection": "0.05 um"}]
BEAMS += [{"guide": "free", "imperfection": "2 um", "residual_stress": "-8 MPa"}]


def changed(**values):
    """The document with other values of the device, of its beam, or in the sweep; None: without."""
    document = copy.deepcopy(DOCUMENT)
    device, sweep = document["device"], document["sweep"]
    for key, value in values.items():
        part = {"beam": device["beam"], "device": device, "sweep": sweep}[key.partition("_")[0]]
        part[key.partition("_")[2]] = value
    for part in (device, device["beam"], sweep):
        for key in [key for key, value in part.items() if value is None]:
            del part[key]
    return document


def faults(document):
    with pytest.raises(ConfigError) as caught:
        load_config(document)
    return caught.value.args


def dense_modes(beam, elements):
    """Mass matrix, squares of frequencies and shapes at the least of the energy, by LAPACK."""
    basis = hermite_elements(elements, free=bool(beam.free)).scaled_to(beam)
    made = q = basis.start
    for _ in range(20):
        stretch = made @ basis.geometric @ made - q @ basis.geometric @ q
        N = beam.axial_stiffness * stretch - beam.residual_stress * beam.area
        slope = basis.geometric @ q
        tangent = basis.bending - N * basis.geometric
        tangent = tangent + 2 * beam.axial_stiffness * np.outer(slope, slope)
        q = q - np.linalg.solve(tangent, basis.bending @ (q - made) - N * slope)
    squares, shapes = scipy.linalg.eigh(tangent, basis.mass)
    return basis, squares, shapes


def symmetric_mode(beam, elements):
    """Frequency and shape of the one of the first two that a shaken frame moves more."""
    basis, squares, shapes = dense_modes(beam, elements)
    first = np.argmax(abs(basis.load @ shapes)[: 1 + bool(beam.free)])
    return np.sqrt(squares[first]), shapes[:, first]


def decay(time, motion):
    """Undamped frequency and quality factor, from the peaks of a swing that dies away."""
    size = abs(motion)
    peak = 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:]))
    rate = -np.polyfit(time[peak], np.log(size[peak]), 1)[0]
    half_period = np.polyfit(np.arange(peak.size), time[peak], 1)[0]
    omega = math.hypot(math.pi / half_period, rate)
    return omega, omega / (2 * rate)


@pytest.mark.parametrize("values", BEAMS, ids=str)
def test_a_free_decay_measures_the_quality_factor_and_frequency_of_the_beam(values):
    document = changed(**{f"beam_{key}": value for key, value in values.items()})
    device = read_device(document["device"])
    model = build_model(device, "reference", elements=5)
    system, n = nodal_system(device, model.basis), model.basis.load.size
    dt = model.steps.longest[MOVE].item()
    history = np.zeros((round(300.0 / dt), 2 * n + 4))
    # A weak, short push: the mass stays away, and the beam's motion is linear.
    follow(
        system, make_pulse().curve, 1e-3 * device.gravity, 0.5, 0.0, -np.inf, dt,
        len(history), history,
    )  # fmt: skip
    dense, _ = symmetric_mode(device.beam, elements=20)
    # Ten elements leave 1e-4 of what twenty have almost to the end: order 4.
    assert natural_frequency(device.beam) == pytest.approx(dense, rel=1.5e-4)
    omega, shape = symmetric_mode(device.beam, elements=5)
    time, free = np.arange(len(history)) * dt, slice(math.ceil(3.0 / dt), None)
    motion = history[free, :n] @ system.inertia @ shape
    measured, quality = decay(time[free], motion)
    # Five elements are up to 2e-3 too fast.
    assert measured == pytest.approx(omega, rel=2e-4)
    assert measured == pytest.approx(natural_frequency(device.beam), rel=2e-3)
    assert quality == pytest.approx(60.0, rel=2e-3)


def test_a_free_decay_measures_the_quality_factor_of_the_mass():
    study = load_config(changed(device_quality_factor=20))
    (C,) = study.axes["C"]
    run = snapmap.simulate(study.device, 0.1, 50e3, C, model="cosines", modes=3, horizon=3000.0)
    after = run.time > 25.0
    omega, quality = decay(run.time.values[after], run.z_mass.values[after] - 10.0 - 5.0)
    assert omega == pytest.approx(math.sqrt(5.5 / 1e4), rel=1e-3)
    assert quality == pytest.approx(20.0, rel=2e-3)


def test_a_quality_factor_stands_for_the_damping():
    study = load_config(DOCUMENT)
    beam = study.device.beam
    assert beam.damping == natural_frequency(replace(beam, damping=0.0)) / 60
    assert study.axes["C"].tolist() == [math.sqrt(5.5 * 1e4) / 94]
    spelled = changed(
        beam_quality_factor=None,
        beam_damping=f"{beam.damping!r} /us",
        device_quality_factor=None,
        sweep_C=[f"{study.axes['C'].item()!r} uN*us/um"],
    )
    again = load_config(spelled)
    assert again.document() == study.document() and again.axes["C"] == study.axes["C"]


def test_quality_factors_are_told_as_they_were_written():
    study = load_config(DOCUMENT)
    (beam, _, of_beam), (mass, _, of_mass) = vibrations(study.device, study.axes["C"])
    assert (beam, of_beam, mass) == ("beam", "60", "mass") and of_mass.startswith("94 at C = ")


def test_axes_and_tolerances_leave_the_damping_as_it_is():
    study = load_config(changed(sweep_thickness=["1.9 um", "2.1 um"], sweep_spring=["5 N/m"]))
    alone = load_config(DOCUMENT)
    assert set(study.grid.device.beam.damping) == {alone.device.beam.damping}
    assert study.axes["C"] == alone.axes["C"]


def test_several_devices_share_one_C():
    def several(**softer):
        two = DOCUMENT["device"] | softer
        parts = {key: value for key, value in DOCUMENT.items() if key != "device"}
        return parts | {"devices": {"one": DOCUMENT["device"], "two": two}}

    assert load_config(several(gap="3 um")).axes["C"] == load_config(DOCUMENT).axes["C"]
    for softer in ({"spring": "4 N/m"}, {"quality_factor": 90}):
        (line,) = faults(several(**softer))
        assert line.startswith("devices: quality factors give each device another C")
    both = several()
    both["sweep"] = both["sweep"] | {"C": ["1 uN*us/um"]}
    keys = [line.split(": ")[0] for line in faults(both)]
    assert keys == [f"devices.{name}.quality_factor" for name in ("one", "two")]


ODD = (
    ({"beam_span": "800 mm"}, ["span/thickness = 400000"]),
    ({"beam_span": "60 um"}, ["rise/span = 0.167"]),
    ({"sweep_f0": ["0.1 Hz", "3 Hz"]}, ["f0 up to 3 Hz"]),
    ({"sweep_f0": ["3 Hz", "1500 MHz"]}, []),
    (
        {"beam_span": "60 um", "beam_thickness": "4 um"},
        ["rise/span = 0.167", "span/thickness = 15"],
    ),
    ({"beam_depth": "22 mm"}, ["depth/span = 36.7"]),
    ({"beam_depth": "22 nm"}, ["depth/thickness = 0.011"]),
    ({"device_gravity": "9810 m/s^2"}, ["gravity = 9810 m/s^2 is outside the usual 0.1 m/s^2 to"]),
    ({"device_gravity": "9.81 mm/s^2"}, ["gravity = 0.00981 m/s^2 is outside the usual 0.1 m/s^2"]),
    ({"device_gravity": "1.62 m/s^2"}, []),
    ({"device_gravity": "490 m/s^2"}, []),
    ({"sweep_thickness": ["2 um", "0.1 um"]}, ["span/thickness = 6000"]),
    ({"device_quality_factor": None, "sweep_C": ["0 kg/s", "0.025 kg/s"]}, ["C = 25000"]),
    ({"sweep_f0": ["1500 MHz"]}, ["f0 from 1500000000 Hz"]),
)


@pytest.mark.parametrize(("values", "values_told"), ODD)
def test_what_is_hardly_meant_is_told(values, values_told):
    lines = [line for line in doubts(load_config(changed(**values))) if "guided" not in line]
    assert len(lines) == len(values_told)
    assert all(line.startswith(start) for line, start in zip(lines, values_told, strict=True))

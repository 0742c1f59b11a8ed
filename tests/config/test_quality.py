"""Quality factors: what a config gives is what a free decay measures; frequencies likewise."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import yaml
from small_studies import MISSING, THREE_COSINES, cases_of, changed, faults

import snapmap
from snapmap.applications.whole import doubts, load_config
from snapmap.beam.elements import hermite_elements
from snapmap.beam.modal import natural_frequency
from snapmap.config.devices import read_device
from snapmap.config.doubts import vibrations
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.ledger import CellRun
from snapmap.solver.models import build_model
from snapmap.solver.nodal import nodal_system
from snapmap.solver.options import Reference
from snapmap.solver.plain_loop import follow
from snapmap.solver.settings import MOVE

CASES = cases_of(__file__)
SWEEP = "sweep: {N: [900, 1000], f0: [1500 Hz]}\nrun: {horizon: 100 us}"
DOCUMENT = yaml.safe_load(THREE_COSINES + SWEEP)
DOCUMENT["device"] |= {"gap": "5 um", "quality_factor": 94}
DOCUMENT["device"]["beam"]["quality_factor"] = 60


def symmetric_mode(beam, elements):
    """Frequency and shape of the one of the first two that a shaken frame moves more, by LAPACK."""
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


@pytest.mark.equation(28)
@pytest.mark.parametrize("values", CASES["beams"], ids=str)
def test_a_free_decay_measures_the_quality_factor_and_frequency_of_the_beam(values):
    section = changed(DOCUMENT["device"], **{f"beam__{key}": values[key] for key in values})
    device = read_device(section)
    model = build_model(device, Reference(elements=5))
    system, n = nodal_system(device, model.basis), model.basis.load.size
    dt = model.steps.longest[MOVE].item()
    history = np.zeros((round(300.0 / dt), 2 * n + 4))
    # A weak, short push: the mass stays away, and the beam's motion is linear.
    push = make_pulse().curve, 1e-3 * device.gravity, 0.5, 0.0
    follow(system, CellRun(*push, -np.inf, dt, len(history), history))
    dense, _ = symmetric_mode(device.beam, elements=20)
    # Ten elements leave 1e-4 of what twenty have almost to the end: order 4.
    assert natural_frequency(device.beam) == pytest.approx(dense, rel=1.5e-4)
    omega, shape = symmetric_mode(device.beam, elements=5)
    time, free = np.arange(len(history)) * dt, slice(math.ceil(3.0 / dt), None)
    measured, quality = decay(time[free], history[free, :n] @ system.inertia @ shape)
    # Five elements are up to 2e-3 too fast.
    assert measured == pytest.approx(omega, rel=2e-4)
    assert measured == pytest.approx(natural_frequency(device.beam), rel=2e-3)
    assert quality == pytest.approx(60.0, rel=2e-3)


def test_a_free_decay_measures_the_quality_factor_of_the_mass():
    study = load_config(changed(DOCUMENT, device__quality_factor=20))
    (C,) = study.axes["C"]
    asked = snapmap.Study(study.device, model=study.model, horizon=3000.0)
    run = snapmap.simulate(asked, 0.1, 50e3, C)
    after = run.time > 25.0
    omega, quality = decay(run.time.values[after], run.z_mass.values[after] - 10.0 - 5.0)
    assert omega == pytest.approx(math.sqrt(5.5 / 1e4), rel=1e-3)
    assert quality == pytest.approx(20.0, rel=2e-3)


def test_a_quality_factor_stands_for_the_damping_and_is_told_as_it_was_written():
    study = load_config(DOCUMENT)
    beam, C = study.device.beam, study.axes["C"]
    assert beam.damping == natural_frequency(replace(beam, damping=0.0)) / 60
    assert C.tolist() == [math.sqrt(5.5 * 1e4) / 94]
    (part, _, of_beam), (other, _, of_mass) = vibrations(study.device, C)
    assert (part, of_beam, other) == ("beam", "60", "mass") and of_mass.startswith("94 at C = ")
    factors = dict.fromkeys(("device__beam__quality_factor", "device__quality_factor"), MISSING)
    spelled = {"device__beam__damping": f"{beam.damping!r} /us", **factors}
    again = load_config(changed(DOCUMENT, **spelled, sweep__C=[f"{C.item()!r} uN*us/um"]))
    assert again.document() == study.document() and again.axes["C"] == C


def test_axes_of_the_device_leave_the_damping_as_it_is():
    alone, axes = load_config(DOCUMENT), {"thickness": ["1.9 um", "2.1 um"], "spring": ["5 N/m"]}
    study = load_config(changed(DOCUMENT, **{f"sweep__{key}": axes[key] for key in axes}))
    assert set(study.grid.device.beam.damping) == {alone.device.beam.damping}
    assert study.axes["C"] == alone.axes["C"]


def test_several_devices_share_one_C():
    def several(**softer):
        devices = {"one": DOCUMENT["device"], "two": DOCUMENT["device"] | softer}
        return changed(DOCUMENT, device=MISSING, devices=devices)

    assert load_config(several(gap="3 um")).axes["C"] == load_config(DOCUMENT).axes["C"]
    for softer in ({"spring": "4 N/m"}, {"quality_factor": 90}):
        (line,) = faults(several(**softer))
        assert line.startswith("devices: quality factors give each device another C")
    lines = faults(changed(several(), sweep__C=["1 uN*us/um"]))
    keys = [f"devices.{name}.quality_factor" for name in ("one", "two")]
    assert [line.split(": ")[0] for line in lines] == keys


BARELY = {"device__beam__rise": "4.8 um", "device__gap": "0 um"}
SCATTERED = {"tolerances": {"thickness": "0.1 um", "rise": "0.2 um", "N": "3 %", "samples": 512}}


def doubted(word, **values):
    """The lines of `doubts` that have a word."""
    return [line for line in doubts(load_config(changed(DOCUMENT, **values))) if word in line]


def test_a_device_that_hardly_has_a_second_shape_is_doubted():
    (line,) = doubted("hardly bistable", **BARELY)
    back, there = re.search(r"back is ([\d.]+) pJ of ([\d.]+) pJ there", line).groups()
    assert 0 < float(back) < 0.02 * float(there)
    pulled = {"device__beam__rise": "10 um", "device__beam__residual_stress": "62 MPa"}
    assert len(doubted("hardly bistable", **pulled)) == 1
    for usual in ({}, {"device__beam__rise": "6 um"}, {"device__beam__residual_stress": "-40 MPa"}):
        assert not doubted("hardly bistable", **usual)


def test_devices_as_made_without_a_second_shape_are_doubted():
    (line,) = doubted("as made", **BARELY, **SCATTERED)
    lost = re.fullmatch(r"device: (\d+) of 512 devices as made have no second stable shape", line)
    # The scatters make rise - 4/sqrt(3) thickness a normal number.
    mean, spread = 4.8 - 8 / math.sqrt(3), math.hypot(0.2, 0.4 / math.sqrt(3))
    share = 0.5 * math.erfc(mean / spread / math.sqrt(2))
    assert int(lost[1]) / 512 == pytest.approx(share, abs=0.03)
    assert not doubted("as made", **SCATTERED) and not doubted("as made", tolerances={"N": "3 %"})
    wide = {"thickness": {"uniform": "2.1 um"}, "samples": 64}
    (line,) = doubted("impossible", tolerances=wide)
    assert line.startswith("device: tolerances.thickness: a sample has the impossible value")


@pytest.mark.parametrize(("values", "told"), CASES["doubts"])
def test_what_is_hardly_meant_is_told_and_nothing_else(values, told):
    lines = [line for line in doubted("", **values) if "guided" not in line]
    assert len(lines) == len(told)
    assert all(line.startswith(start) for line, start in zip(lines, told, strict=True))

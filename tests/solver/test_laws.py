"""Laws of a user's own, the examples among them, against SciPy and closed forms."""

import re
import runpy
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import yaml
from scipy.signal import lsim
from small_studies import THREE_COSINES, cases_of

import snapmap
from snapmap import Study
from snapmap.applications import gather
from snapmap.applications.page.figure import OF_LAWS, page
from snapmap.applications.whole import doubts, load_config
from snapmap.config.doubts import descriptions
from snapmap.device.device import batch
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.bounds import least_amplitudes
from snapmap.solver.cells import to_rows
from snapmap.solver.laws import PARAMETERS, load_laws
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines, Elements
from snapmap.solver.outcome import SNAPPED
from snapmap.solver.settings import Run
from snapmap.study.provenance import device_sections
from snapmap.thresholds.probe import Probe, lowest_snap
from snapmap.values.faults import Faults

F0 = 1500.0
SWEEP = "sweep: {N: [600, 900], f0: [1 kHz], C: [25 uN*us/um]}\nrun: {horizon: 0 us}"


@pytest.fixture
def law_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path / "mylaws.py"


@pytest.fixture(scope="module")
def laws(root):
    return cache(lambda name: load_laws(str(root / "examples" / "laws" / f"{name}.py")))


@pytest.fixture(scope="module")
def double_well(handout, laws):
    """A device of one degree of freedom, its laws and its model."""
    device = replace(handout, contact=500.0, spring=0.05)
    model = {"force": laws("double_well").force, "contact": laws("fixed_mass").contact}
    made = Cosines(laws=model)
    return device, made, build_model(batch([device]), made)


def first_snap(model, rows, expected, tolerance):
    bracket = 0.9 * expected, 1.1 * expected
    return lowest_snap(Probe(model, rows, Run(horizon=1500.0)), bracket, tolerance).item()


def test_a_short_pulse_must_bring_the_energy_of_the_saddle_a_slow_one_the_force(double_well, laws):
    """The mass m of the first cosine gets the load of the whole beam: its share is 4/3 of its own.

    So little comes to swing within that the tied mass has (M + f)^2 / (M + m) v^2 / 2.
    """
    device, _, model = double_well
    x, force = np.linspace(0.0, 8.5, 100_001), laws("double_well").force
    F = np.array([force(place) for place in x]) + device.spring * x
    energy = np.cumsum((F[1:] + F[:-1]) / 2 * np.diff(x)).max()
    load, inertia = device.beam.weight / 2, 3 * device.beam.weight / 8
    speed = np.sqrt(2 * energy * (device.mass + inertia)) / (device.mass + load)
    N, within = 2 * speed * 1.0 / device.gravity, inertia * (load / inertia) ** 2 / device.mass
    assert first_snap(model, to_rows(0, [1e6], 0.0), N, 1e-6) == pytest.approx(N, rel=within)
    N = F.max() / (device.mass + load) / device.gravity
    assert first_snap(model, to_rows(0, [30.0], 0.0), N, 1e-5) == pytest.approx(N, rel=2e-4)


def test_a_double_well_withstands_what_its_energy_proves(double_well):
    """From its closed form; and a short pulse needs little more."""
    device, _, built = double_well
    speed = np.sqrt(2 * 20 * 224 / 27 / (device.mass + device.beam.weight))
    pulses = make_shocks(["half sine", "sawtooth"], "both").pulses
    rows = to_rows(0, np.repeat([3e3, 1e6], 4), 0.0, np.tile(np.arange(4), 2), pulses)
    area = np.array([pulse.gross_area for pulse in pulses])[rows.pulse]
    bound = least_amplitudes(built, rows)
    assert bound == pytest.approx(speed * rows.f0 / (1e6 * area * device.gravity), rel=1e-5)
    cells = rows.cells(built.device, np.multiply.outer(bound, [0.5, 0.999]), 1500.0)
    runs = built.follow(cells, Run())
    assert np.isnan(runs.t_snap).all() and (runs.energy_error < 1e-3).all()
    N = first_snap(built, rows.take([4]), bound[4], 1e-3)  # a half sine that presses
    assert bound[4] < N < 1.02 * bound[4]


@pytest.mark.parametrize(
    ("contact", "gap", "stores"),
    [
        (lambda stiffness, overlap: stiffness * overlap, 0.0, True),
        (lambda stiffness, overlap: stiffness * overlap, 0.5, False),  # it pulls at first
        (lambda stiffness, overlap: 60.0 * max(0.0, overlap) ** 1.5, 0.5, True),
        (lambda stiffness, overlap: stiffness * max(0.0, overlap) - 0.1, 0.0, False),  # a magnet
    ],
)
def test_a_contact_has_an_energy_that_proves_or_has_not(handout, contact, gap, stores):
    device, rows = batch([replace(handout, gap=gap)]), to_rows(0, [F0], 0.0)
    model = build_model(device, Elements(laws={"contact": contact}))
    plain = least_amplitudes(build_model(device, Elements()), rows)
    assert least_amplitudes(model, rows) == stores * plain


def test_of_a_double_well_nothing_is_said_that_nobody_knows(double_well):
    device, model, _ = double_well
    run = snapmap.simulate(Study(device, model, horizon=0.0), 400, 500, 0.0)
    assert run.barrier == pytest.approx(20 * 224 / 27, rel=1e-5) and run.outcome == SNAPPED
    assert run.second_equilibrium == pytest.approx(device.beam.rise - 18, abs=1e-3)
    assert np.isnan(run.stress).all()


REFUSED = cases_of(__file__)


@pytest.mark.parametrize("written", REFUSED)
def test_a_file_that_has_no_laws_is_refused_in_a_line(handout, law_file, written):
    law_file.write_text(written)
    line = re.escape(f"mylaws.py{REFUSED[written]}")
    with pytest.raises(ValueError, match=rf"\A(model\.)?laws: {line}.*\Z"):
        build_model(handout, Elements(laws="mylaws.py"))


@pytest.mark.parametrize("name", [".a.py", "numpy.py", "my.laws.py"])
def test_a_file_of_laws_may_have_any_name(law_file, name):
    """Numba would import the module of that name."""
    law_file.with_name(name).write_text("k = 2.0\ndef damping(C, v, y): return k * C * v")
    assert load_laws(name).damping(3.0, 5.0, 0.0) == 30.0


def test_a_force_has_one_degree_of_freedom(handout, laws):
    force = Elements(4, laws={"force": laws("double_well").force})
    with pytest.raises(ValueError, match=r"model\.elements: does not work with these laws"):
        build_model(handout, force)


CONFIG = yaml.safe_load(THREE_COSINES + SWEEP)
CONFIG |= {"model": {"name": "elements", "laws": "mylaws.py"}}
CUBIC = CONFIG | {"sweep": CONFIG["sweep"] | {"C": ["3e4 uN*us^3/um^3"]}}
CELLS = {"histories": [{"N": 900, "f0": "1 kHz", "C": "25 uN*us/um"}]}
OF_CUBIC = {"histories": [{"N": 900, "f0": "1 kHz", "C": "25 uN*us^3/um^3"}]}


def outputs(study):
    return gather(lambda part: part.outputs(study))


def test_a_config_names_a_file_of_laws(root, law_file):
    with pytest.raises(Faults, match=r"^model\.laws: mylaws\.py: is not there$"):
        load_config(CONFIG)
    law_file.write_text((root / "examples" / "laws" / "cubic_damping.py").read_text())
    study = load_config(CUBIC)
    assert outputs(study)["statics"]  # of the beam, which the law leaves as it is
    assert "not known under model.laws" in descriptions(study)[0]
    assert not any("critical" in line for line in doubts(study))
    law_file.write_text(law_file.read_text() + "\n")
    edited = load_config(CUBIC)
    assert study.inputs() != edited.inputs()
    assert study.files()["mylaws.py"] == study.model.laws.sha256 != edited.model.laws.sha256
    in_kernel = load_config(CUBIC | {"model": {"name": "cosines", "laws": "mylaws.py"}})
    assert in_kernel.model.laws.sha256 == edited.model.laws.sha256
    with pytest.raises(Faults, match=r"^model\.laws: auto takes none; write name: elements, or c"):
        load_config(CONFIG | {"model": {"name": "auto", "laws": "mylaws.py"}})
    with pytest.raises(Faults, match=r"^laws: does not work with model"):
        load_config(CUBIC | {"laws": True})


def test_products_are_made_that_laws_leave_as_they_are(root, law_file):
    examples = root / "examples" / "laws"
    law_file.write_text((examples / "cubic_damping.py").read_text())
    made = outputs(load_config(CUBIC | OF_CUBIC))
    assert made["statics"] and made["histories"]
    law_file.write_text((examples / "double_well.py").read_text())
    assert "statics" not in outputs(load_config(CONFIG | CELLS))


def test_the_page_of_a_law_says_that_it_follows_no_shock(handout):
    axes, laws = ([900.0], [F0], [3e4]), {"damping": lambda C, v, y: C * v}
    cube = snapmap.sweep(Study(handout, Elements(laws=laws)), *axes)
    edges = snapmap.threshold(handout, *axes[1:])
    shown = {"horizon": 0.0, "title": "", "pulse": {}, "required": ()}
    text = page(cube, edges, shown | {"written": device_sections(handout)})
    assert OF_LAWS in text and '"pieces": null' in text and "critical: " not in text


def test_a_law_counts_C_in_the_unit_that_it_states(handout):
    """A drag of C velocity^2 has kg/m."""
    seen = {"damping": lambda C, velocity, place: C * abs(velocity) * velocity}
    model = Elements(laws=seen | {"unit_of_C": "uN*us^2/um^2"})
    study = snapmap.Study(handout, model, until="snap")
    cube = snapmap.sweep(study, [900.0], [F0], ["6e-6 kg/m", "7 uN*us^2/um^2", 8.0])
    assert cube.C.values.tolist() == pytest.approx([6.0, 7.0, 8.0])
    assert cube.C.units == "uN us2 um-2" and cube.N.units == "1"
    assert snapmap.sweep(study, [900.0], [F0], cube.C).identical(cube)
    title = snapmap.plot_outcome(cube.sel(C=8.0)).get_title()
    assert "$C$ = 8 µN µs$^{2}$ µm$^{-2}$" in title
    line = r"^C: '7 uN\*us/um' does not convert to uN\*us\^2/um\^2; "
    with pytest.raises(ValueError, match=line):
        snapmap.sweep(study, [900.0], [F0], "7 uN*us/um")
    own = snapmap.Study(handout, Elements(laws=seen), until="snap")
    own = snapmap.sweep(own, [900.0], [F0], "7 uN*us/um")  # as without a unit
    assert own.C.units == "uN us um-1" and "unit_of_C" not in own.attrs["config"]


def test_a_config_writes_C_in_the_unit_of_its_law(root, law_file):
    law_file.write_text((root / "examples" / "laws" / "cubic_damping.py").read_text())
    study = load_config(CUBIC | {"sweep": CUBIC["sweep"] | {"C": ["2e-8 N*s^3/m^3"]}})
    assert study.axes["C"] == pytest.approx([0.02]) and study.units["C"][0] == "N*s^3/m^3"
    assert study.document()["model"]["unit_of_C"] == study.unit_of_C == "uN*us^3/um^3"
    wrong = CONFIG | CELLS | {"maps": [{"x": "f0", "y": "N", "at": {"C": "25 uN*us/um"}}]}
    with pytest.raises(Faults) as caught:
        load_config(wrong)
    such = "write a damper constant such as '25 uN*us^3/um^3'"
    needs = f"'25 uN*us/um' does not convert to uN*us^3/um^3; {such}"
    assert set(caught.value.args) == {f"{at}: {needs}" for at in ("sweep.C[0]", "histories[0].C")}
    sweep = {key: value for key, value in CONFIG["sweep"].items() if key != "C"}
    damped = {"device": CONFIG["device"] | {"quality_factor": 200}, "sweep": sweep}
    with pytest.raises(Faults, match=r"^device\.quality_factor: gives C in uN\*us/um, but "):
        load_config(CONFIG | damped)


def test_statics_of_a_law_in_place_of_the_beams_force_are_refused(handout, laws):
    study = snapmap.Study(handout, snapmap.Cosines(laws=laws("double_well")))
    with pytest.raises(ValueError, match=r"^model\.laws: force: statics are of the device's own"):
        snapmap.statics(study)


def test_the_laws_on_the_page_are_those_of_the_examples(root, laws):
    text = (root / "docs" / "own-physics.md").read_text(encoding="utf-8")
    written = [b for b in re.findall(r"^```python\n(.*?)^```", text, re.M | re.S) if ".py," in b]
    for block in written:
        exec(block, names := {})
        name = re.search(r"# (\w+)\.py", block).group(1)
        law = next(key for key in ("damping", "contact", "force") if key in names)
        ours = getattr(laws(name), law)
        for at in np.random.default_rng(3).uniform(-2.0, 2.0, (9, 3))[:, : len(PARAMETERS[law])]:
            assert names[law](*at.tolist()) == pytest.approx(ours(*at.tolist()), rel=1e-12)
        assert names.get("unit_of_C", "uN*us/um") == laws(name).unit_of_C
    assert len(written) == len([*(root / "examples" / "laws").glob("*.py")])


def test_a_model_of_ones_own_is_asked_as_those_of_snapmap_are(root, handout):
    """The mass on its spring is linear: it falls in proportion to N."""
    names = runpy.run_path(root / "examples" / "own_model.py")
    model, rows = names["MassAlone"](handout), to_rows(0, [2000.0], [25.0])
    run = Run(horizon=100.0, until="snap", repeat=False)
    (found,) = lowest_snap(Probe(model, rows, run), (100.0, 4000.0), 1e-3)
    t, C = np.linspace(0.0, 600.0, 6001), 25.0
    shock = handout.gravity * np.where(t < 500.0, np.sin(np.pi * t / 500.0) ** 2, 0.0)
    system = [-1.0], [1.0, C / handout.mass, handout.spring / handout.mass]
    deepest = -lsim(system, shock, t)[1].min()
    assert found == pytest.approx(names["DEPTH"] / deepest, rel=2e-3)

"""Laws of a user's own, the examples among them, against SciPy and closed forms."""

import runpy
from dataclasses import replace

import numpy as np
import pytest
import yaml
from scipy.integrate import solve_ivp
from small_studies import THREE_COSINES

import snapmap
from snapmap.beam.elements import hermite_elements
from snapmap.config.study import load_config
from snapmap.config.yaml_file import ConfigError
from snapmap.device.device import batch
from snapmap.files.named import sha256_of
from snapmap.solver.cells import to_rows
from snapmap.solver.laws import LAWS, load_laws
from snapmap.solver.models import build_model
from snapmap.solver.plain_loop import nodal_system
from snapmap.solver.settings import Settings
from snapmap.study.study import Study
from snapmap.sweeps.cube import as_cube
from snapmap.sweeps.grid import follow_grid
from snapmap.thresholds.search import lowest_snap

F0 = 1500.0
SWEEP = "sweep: {N: [600, 900], f0: [1 kHz], C: [25 uN*us/um], horizon: 0 us}"


@pytest.fixture(scope="module")
def laws(root):
    return lambda name: load_laws(str(root / "examples" / "laws" / f"{name}.py"))


def scipy_snap(device, laws, N, C):
    """When the elements of the reference snap under laws, us, by solve_ivp."""
    system, a0 = nodal_system(device, hermite_elements(5)), N * device.gravity
    n, M, K = system.load.size, device.mass, device.spring
    target = device.beam.second_equilibrium - device.beam.rise
    damping = laws.damping.py_func if laws.damping else lambda C, v, y: C * v
    contact = laws.contact.py_func if laws.contact else lambda k, s: k * max(0.0, s)

    def rate(t, x):
        u, y, v = x[:n], x[n], x[-1]
        a = a0 / 2 * (1 - np.cos(2e-6 * np.pi * F0 * t)) if t < 1e6 / F0 else 0.0
        slope = system.geometric @ u + system.slope_start
        axial = -system.axial * u @ (slope + system.slope_start)
        P = contact(device.contact, system.midpoint @ u - y - device.gap)
        force = axial * slope - system.bending @ u - system.load * a - system.midpoint * P
        of_mass = -a + (P - K * y - damping(C, v, y)) / M
        return np.concatenate([x[n + 1 :], system.inverse_inertia @ force, [of_mass]])

    def snaps(t, x):
        return system.midpoint @ x[:n] - target

    snaps.terminal = True
    start = np.zeros(2 * n + 2)
    run = solve_ivp(rate, (0, 2000), start, "DOP853", events=snaps, rtol=1e-8, atol=1e-8)
    return run.t_events[0][0]


@pytest.mark.parametrize(
    ("name", "N", "C", "change"),
    [
        ("cubic_damping", 2500.0, 4000.0, 5.0),
        ("squeeze_film", 2500.0, 200.0, 5.0),
        ("hertzian_contact", 1500.0, 25.0, 1.0),
        ("fixed_mass", 1500.0, 25.0, 1e-2),
    ],
)
def test_an_example_moves_as_scipy_says(handout, laws, name, N, C, change):
    """And otherwise than the device does without it."""
    model = snapmap.reference(**vars(laws(name)))
    cell = {"N": [N], "f0": [F0], "C": [C], "horizon": 100.0, "until": "snap"}
    without = snapmap.sweep(handout, model="reference", **cell).t_snap.item()
    cube = snapmap.sweep(handout, model=model, repeat=True, **cell)
    assert cube.t_snap.item() == pytest.approx(scipy_snap(handout, laws(name), N, C), abs=0.01)
    assert not abs(cube.t_snap.item() - without) < change
    assert cube.outcome.item() == 2 and cube.reproduced.item() == 1  # open: nothing is proven


@pytest.fixture(scope="module")
def double_well(handout, laws):
    """A device of one degree of freedom, its model, and its force over displacement."""
    device = replace(handout, contact=500.0, spring=0.05)
    force, contact = laws("double_well").force, laws("fixed_mass").contact
    x = np.linspace(0.0, 8.5, 100_001)
    F = np.array([force(place) for place in x]) + device.spring * x
    return device, snapmap.reference(force=force, contact=contact), x, F


def first_snap(device, model, f0, expected, tolerance, horizon=1500.0):
    rows = to_rows([0], [f0], [0.0])
    bracket = 0.9 * expected, 1.1 * expected
    return lowest_snap(model, rows, bracket, Settings(horizon=horizon), tolerance).item()


def test_a_short_pulse_must_bring_the_energy_of_the_saddle(double_well):
    """The mass m of the first cosine gets the load of the whole beam: its share is 4/3 of its own.

    So little comes to swing within that the tied mass has (M + f)^2 / (M + m) v^2 / 2.
    """
    device, model, x, F = double_well
    energy = np.cumsum((F[1:] + F[:-1]) / 2 * np.diff(x)).max()
    load, inertia = device.beam.weight / 2, 3 * device.beam.weight / 8
    speed = np.sqrt(2 * energy * (device.mass + inertia)) / (device.mass + load)
    built = build_model(batch([device]), **model)
    N = 2 * speed * 1.0 / device.gravity
    within = inertia * (load / inertia) ** 2 / device.mass
    assert first_snap(device, built, 1e6, N, 1e-6) == pytest.approx(N, rel=within)


def test_a_slow_pulse_must_bring_the_largest_force(double_well):
    device, model, _, F = double_well
    N = F.max() / (device.mass + device.beam.weight / 2) / device.gravity
    built = build_model(batch([device]), **model)
    assert first_snap(device, built, 30.0, N, 1e-5) == pytest.approx(N, rel=2e-4)


def test_of_a_double_well_nothing_is_said_that_nobody_knows(double_well):
    device, model, *_ = double_well
    run = snapmap.simulate(device, 400, 500, 0.0, model=model, horizon=0.0)
    assert run.barrier == pytest.approx(20 * 224 / 27, rel=1e-5) and run.outcome == "snapped"
    assert run.second_equilibrium == pytest.approx(device.beam.rise - 18, abs=1e-3)
    assert np.isnan(run.stress).all() and np.isnan(run.contact_energy).all()
    with pytest.raises(ValueError, match=r"model\.laws: work only with simulate, sweep, threshold"):
        snapmap.tolerance(device, {"mass": 1.0}, N=[1], f0=[1], C=[1], model=model)


def test_a_law_that_is_too_stiff_for_the_step_is_followed_in_shorter_ones(handout):
    """A contact 200 times as stiff as the device's, as if the device had it."""

    def stiffer(stiffness, overlap):
        return 200 * stiffness * max(0.0, overlap)

    model = snapmap.reference(contact=stiffer)
    given = [1500.0], [F0], [25.0]
    cube = snapmap.sweep(handout, *given, model=model, until="snap", horizon=50.0)
    hard = replace(handout, contact=200 * handout.contact)
    assert cube.halvings.item() > 0
    plain = snapmap.sweep(hard, *given, model="reference", until="snap", horizon=50.0)
    assert cube.t_snap.item() == pytest.approx(plain.t_snap.item(), abs=0.2)


@pytest.mark.parametrize(
    ("written", "line"),
    [
        ("def damping(v): return v", "damping: takes (v); write (C, velocity, place)"),
        ("x = 1", "no law; write a function named damping or contact or force"),
        ("def contact(k, s): return 'a'", "contact: returns a str; return a float"),
        ("def contact(k, s): return open(s)", "contact: numba cannot compile it; "),
        ("damping = 1", "damping: is not a function"),
        ("def force(x): return x", "force: no double well; make it 0 at 0, then"),
        ("def force(x)", "mylaws.py: SyntaxError: expected ':' (mylaws.py, line 1)"),
    ],
)
def test_a_file_that_has_no_laws_is_one_line(handout, tmp_path, monkeypatch, written, line):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mylaws.py").write_text(written)
    with pytest.raises(ValueError) as told:
        build_model(handout, "reference", laws="mylaws.py", sha256=sha256_of("mylaws.py", *LAWS))
    assert str(told.value).startswith(f"model.laws: {line}")
    assert "\n" not in str(told.value)


def test_what_laws_do_not_know_is_refused(handout, laws):
    contact = snapmap.reference(contact=laws("fixed_mass").contact)
    with pytest.raises(ValueError, match=r"device\.stops: do not work with a law of the contact"):
        build_model(replace(handout, stop_away=3.0), **contact)
    force = snapmap.reference(force=laws("double_well").force) | {"elements": 5}
    with pytest.raises(ValueError, match=r"model\.elements: has no effect with a law of the force"):
        build_model(handout, **force)


def test_a_config_names_a_file_of_laws(root, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    law = tmp_path / "mylaws.py"
    config = yaml.safe_load(THREE_COSINES + SWEEP) | {
        "model": {"name": "reference", "laws": "mylaws.py"}
    }
    with pytest.raises(ConfigError, match=r"^model\.laws: mylaws\.py: is not there$"):
        load_config(config)
    law.write_text((root / "examples" / "laws" / "cubic_damping.py").read_text())
    study = load_config(config)
    law.write_text(law.read_text() + "\n")
    edited = load_config(config)
    assert study.inputs() != edited.inputs()
    assert study.files()["mylaws.py"] == study.model["sha256"] != edited.model["sha256"]
    with pytest.raises(ConfigError, match=r"^model\.laws: is not an option of auto"):
        load_config(config | {"model": {"name": "auto", "laws": "mylaws.py"}})
    with pytest.raises(ConfigError, match=r"^tolerances: does not work with model"):
        load_config(config | {"tolerances": {"thickness": "1 %"}})


def test_a_solver_of_ones_own_makes_a_cube_and_a_threshold(root, handout):
    """A mass on its spring under a pulse of two of its periods: closed form, with w t = 2 x."""
    drop = runpy.run_path(root / "examples" / "scipy_model.py")["Drop"]
    grid = Study(device=handout).set_out({"C": [0.0], "f0": [1000.0, 3000.0], "N": [100, 2000]})
    values = follow_grid(drop(grid.device, 20.0), grid, Settings(until="snap", repeat=True))
    cube = as_cube(grid.axes, values, {})
    assert cube.outcome.squeeze().values.tolist() == [[0, 2], [0, 2]]
    f0 = np.sqrt(handout.spring / handout.mass) / (4e-6 * np.pi)
    x = np.linspace(0, 2 * np.pi, 100_001)
    falls = np.max((1 - np.cos(2 * x)) / 2 - 2 / 3 * (np.cos(x) - np.cos(2 * x)))
    N = 20 * handout.spring / (falls * handout.mass * handout.gravity)
    found = first_snap(handout, drop(batch([handout]), 20.0), f0, N, 1e-4, 0.0)
    assert found == pytest.approx(N, rel=1e-3)

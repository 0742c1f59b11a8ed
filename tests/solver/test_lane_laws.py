"""Laws of a user's own in the kernel, beside the device's own, SciPy and energies."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from varied import varied

import snapmap
from snapmap import Cosines, Elements, Study
from snapmap.device.device import batch
from snapmap.solver.bounds import least_amplitudes
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.kernel.tables import CELLS, least_energy, look_up, potentials
from snapmap.solver.laws import compile_laws, load_laws
from snapmap.solver.models import build_model
from snapmap.solver.motion import largest_stress
from snapmap.solver.settings import Run
from studies.peers.equations import equations_of
from studies.peers.scipy_ivp import by_scipy

COSINES, ELEMENTS = Cosines(modes=3), Elements(elements=2)
"""Three modes both: the same kernel."""
SETTLED = Run()
N, F0 = np.meshgrid(np.linspace(700.0, 2500.0, 7), [700.0, 1500.0, 5000.0])


@cache
def laws_of(**functions):
    return compile_laws(functions)


def linear_drag(C, velocity, place):
    return C * velocity


def cubic_drag(C, velocity, place):
    return C * velocity**3


def one_sided(stiffness, overlap):
    return stiffness * max(0.0, overlap)


def two_sided(stiffness, overlap):
    return stiffness * overlap


def hertz(stiffness, overlap):
    return 60.0 * max(0.0, overlap) ** 1.5


def follow(device, model, laws, C, settings=SETTLED, step=1.0):
    built = build_model(device, replace(model, laws=laws)).with_step(step)
    return built.follow(to_cells(built.device, 0, N, F0, C, 300.0), settings)


DEVICES = {"soft": {}, "gap": {"gap": 1.0, "contact": 400.0}, "damped beam": {"damping": 4e-3}}
LINEAR = {"damping": linear_drag, "contact": one_sided}


EACH = [(name, key) for name in DEVICES for key in [("damping",), ("contact",), (*LINEAR,)]]


@pytest.mark.parametrize(
    ("name", "keys"),
    [pytest.param(*one, marks=[pytest.mark.long] * (one[1] != (*LINEAR,))) for one in EACH],
)
def test_the_devices_own_forces_as_laws_do_the_same(handout, name, keys):
    """The contact is in series with the flexibility of the modes left out."""
    device, settings = varied(handout, **DEVICES[name]), Run(horizon=300.0)
    laws = laws_of(**{key: LINEAR[key] for key in keys})
    ours = follow(device, COSINES, laws, 25.0, settings)
    plain = follow(device, COSINES, None, 25.0, settings)
    assert 0 < np.isfinite(plain.t_snap).sum() < N.size
    np.testing.assert_allclose(ours.t_snap, plain.t_snap, rtol=2e-6)
    stays = np.isnan(plain.t_snap)  # after a snap all is chaotic
    np.testing.assert_array_equal(ours.t_settled[stays], plain.t_settled[stays])
    assert ours.energy_error.max() < 1e-8 and (ours.halvings == 0).all()


def test_stops_and_a_hard_contact_go_with_a_law_of_damping(handout):
    stops = {"stop_toward": 14.0, "stop_away": 1.0, "restitution": 0.8}
    for device in (varied(handout, **stops), varied(handout, contact=np.inf)):
        ours = follow(device, COSINES, laws_of(damping=linear_drag), 25.0)
        plain = follow(device, COSINES, None, 25.0)
        assert np.isfinite(plain.t_snap).any()
        np.testing.assert_array_equal(np.isfinite(ours.t_snap), np.isfinite(plain.t_snap))
        np.testing.assert_allclose(ours.t_snap, plain.t_snap, rtol=1e-3)


@pytest.mark.equation(13)
@pytest.mark.parametrize(
    ("damping", "contact", "C"),
    [("cubic_damping", "hertzian_contact", 4000.0), ("squeeze_film", "fixed_mass", 200.0)],
)
def test_the_examples_of_laws_move_as_scipy_says(handout, root, damping, contact, C):
    """And come closer to it with the square of the step."""
    examples = root / "examples" / "laws"
    laws, contact = (load_laws(str(examples / f"{name}.py")) for name in (damping, contact))
    laws = replace(laws, contact=contact.contact)
    moved = Run(repeat=False).but(until="moved")
    equations = equations_of(build_model(handout, ELEMENTS))
    cells = to_cells(handout, 0, N, F0, C, 300.0).flat()
    exact = by_scipy(equations, "DOP853", 1e-9, laws)(cells).reshape(N.shape)
    errors = []
    for step in (0.5, 0.25, 0.125):
        ours = follow(handout, ELEMENTS, laws, C, moved, step=step).t_snap
        assert (np.isfinite(ours) == np.isfinite(exact)).all()
        errors.append(np.nanmedian(abs(ours - exact)))
    assert errors[-1] < 5e-4 and errors[0] > 8 * errors[-1]


@pytest.mark.equation(42)
@pytest.mark.parametrize("contact", [hertz, two_sided])
def test_what_a_contact_takes_it_gives_back(handout, contact):
    """Over thousands of contacts without a damper, in steps ten times apart."""
    laws, settings = laws_of(contact=contact), Run(horizon=5000.0)
    model = build_model(handout, snapmap.Cosines(modes=3, laws=laws))
    model = replace(model, barrier=model.barrier._replace(energy=0.0))
    cells = to_cells(handout, 0, [880.0, 1100.0, 1500.0], 1500.0, 0.0, 5000.0)
    for factor in (0.5, 1.0, 5.0):
        seen = model.with_step(factor).follow_once(cells, settings)
        assert seen.energy_error.max() < 1e-7


def test_a_run_that_is_proven_to_stay_stays(handout):
    laws = laws_of(damping=cubic_drag, contact=hertz)
    proven = follow(handout, COSINES, laws, 3e4)
    settled = np.isfinite(proven.t_settled)
    assert settled.sum() > 5
    model = build_model(handout, snapmap.Cosines(modes=3, laws=laws))
    open_ended = replace(model, barrier=model.barrier._replace(energy=-np.inf))
    cells = to_cells(handout, 0, N, F0, 3e4, 3000.0)
    moved = open_ended.follow(cells, Run(horizon=3000.0))
    assert np.isnan(moved.t_settled).all()
    first = settled & (proven.well == 1) & np.isnan(proven.t_snap)
    assert first.any() and np.isnan(moved.t_snap[first]).all()


GIVING = (
    lambda C, velocity, place: C * velocity * (1.0 if abs(velocity) > 0.01 else -0.1),
    lambda C, velocity, place: C * velocity * (-0.2 if abs(place) < 0.3 else 1.0),
    lambda C, velocity, place: C * velocity * (1.0 if abs(place) > 0.9 else place),
)


def test_of_a_law_that_gives_energy_nothing_is_proven(handout):
    """It has the right sign where it is checked at first, and its ledger closes."""
    near = lambda C, v, place: C * v * (-0.2 if abs(place) < 1 - 1e-9 else 1.0)  # noqa: E731
    rows, each = to_rows(0, [1500.0], 25.0), (None, cubic_drag, near)
    models = [{"damping": damping} if damping else None for damping in each]
    built = (build_model(batch([handout]), Cosines(modes=3, laws=laws)) for laws in models)
    plain, same, none = (least_amplitudes(model, rows).item() for model in built)
    assert plain == same > 0 == none
    drags, run = (laws_of(damping=drag) for drag in (linear_drag, *GIVING)), Run(horizon=1500.0)
    passive, *giving = (follow(handout, COSINES, drag, 25.0, run) for drag in drags)
    assert np.isfinite(passive.t_settled).any()
    for ours in giving:
        assert np.isnan(ours.t_settled).all() and ours.energy_error.max() < 1e-3


def test_a_contact_whose_energy_has_no_bottom_proves_nothing(handout):
    def drives_apart(stiffness, overlap):
        return stiffness * overlap if overlap > 0 else 0.05

    ours = follow(handout, ELEMENTS, laws_of(contact=drives_apart), 25.0)
    assert np.isnan(ours.t_settled).all() and ours.energy_error.max() < 1e-3


def test_a_device_of_a_batch_has_its_own_tables_and_a_cell_does_not_depend_on_its_company(handout):
    devices = [varied(handout, contact=40.0), varied(handout, contact=70.0, rise=11.0)]
    laws = laws_of(damping=cubic_drag, contact=one_sided)
    together = build_model(batch(devices), snapmap.Cosines(modes=3, laws=laws))
    levels, order = np.linspace(700, 2500, 19), np.random.default_rng(3).permutation(38)
    cells = to_cells(together.device, [[0], [1]], levels, 1500.0, 3e4, 300.0)
    mixed = together.follow(cells, Run())[:8]
    shuffled = together.follow(cells.flat().take(order), Run(threads=2))[:8]
    for whole, part in zip(mixed, shuffled, strict=True):
        np.testing.assert_array_equal(whole.ravel()[order], part)
    for i, device in enumerate(devices):
        one = to_cells(device, 0, levels, 1500.0, 3e4, 300.0)
        for model in (build_model(device, snapmap.Cosines(modes=3, laws=laws)), together.pick(i)):
            for whole, alone in zip(mixed, model.follow(one, Run())[:8], strict=True):
                np.testing.assert_array_equal(whole[i], alone)


def test_a_table_is_the_integral_of_its_law():
    def force(x):
        return 60.0 * np.maximum(0.0, x) ** 1.5 - 0.3 * (x > -1) * (x < 0) + 0.1 * x

    table = potentials(force, 100.0)
    for x in (-60.0, -0.4, 1e-4, 0.02, 1.7, 30.0):
        breaks = [p for p in (-1.0, 0.0) if min(0, x) < p < max(0, x)]
        energy, slope = look_up(table, 100.0, np.array([x]))
        exact = quad(force, 0, x, points=breaks or None, epsabs=1e-12)[0]
        assert energy.item() == pytest.approx(exact, abs=3e-4, rel=1e-8)
        assert slope.item() == pytest.approx(force(x), rel=2e-3, abs=1e-4)
    x = np.linspace(-100, 100, 100_001)
    assert look_up(table, 100.0, x)[0].min() >= least_energy(table) > -np.inf
    assert least_energy(potentials(lambda x: -0.1 + 0 * x, 100.0)) == -np.inf


def test_the_flexibility_of_modes_left_out_is_in_series(handout):
    model = build_model(handout, snapmap.Cosines(modes=3, laws=laws_of(contact=hertz)))
    assert model.tables.values.shape == (2, CELLS, 4)
    c, x = float(model.modal.residual), np.array([0.003, 0.4, 2.0, 5.0])
    _, push = look_up(model.tables.values[1], 100.0, x)
    s = [brentq(lambda s: s + c * hertz(0.0, s) - end, 0, end) for end in x]  # noqa: B023
    np.testing.assert_allclose(push, [hertz(0.0, overlap) for overlap in s], rtol=1e-4, atol=1e-4)


def test_an_error_of_a_law_in_a_kernel_is_one_line(handout):
    def damping(C, velocity, place):
        if abs(velocity) > 0.3:
            raise ValueError("too fast")
        return C * velocity

    line = r"\Amodel\.laws: .+, line \d+: damping: ValueError: too fast\Z"
    with pytest.raises(ValueError, match=line):
        follow(handout, COSINES, laws_of(damping=damping), 25.0)


def falling(stiffness, overlap):
    return -900.0 * overlap


REFUSED = {
    "device.contact: hard": ({"contact": np.inf}, {"contact": two_sided}, {"modes": 3}),
    "device.stop_away": ({"stop_away": 3.0}, {"contact": two_sided}, {"modes": 3}),
    r"model.laws: .+, line \d+: contact: falls": ({}, {"contact": falling}, {"modes": 3}),
    "device.contact_at": ({"contact_at": -2.0}, {"contact": two_sided}, {"modes": 3}),
    "model.modes": ({}, {"force": lambda x: x * (x - 8) * (x - 18)}, {"modes": 3}),
}


@pytest.mark.parametrize("line", REFUSED)
def test_what_a_kernel_cannot_do_is_refused_in_a_line(handout, line):
    change, laws, options = REFUSED[line]
    with pytest.raises(ValueError, match=rf"\A{line}[^\n]*\Z"):
        build_model(varied(handout, **change), snapmap.Cosines(laws=laws, **options))


def test_a_history_shows_the_laws_energy(handout):
    """All energies add up to the work of the pulse less the loss."""
    model = snapmap.Cosines(modes=3, laws={"damping": cubic_drag, "contact": hertz})
    run = snapmap.simulate(Study(handout, model, horizon=0.0), 1100.0, 1500.0, 4000.0)
    stored = sum(run[key] for key in run if key.endswith("_energy"))
    assert abs(stored - run.pulse_work).max() < 1e-6 * run.pulse_work.max()
    assert run.contact_energy.max() > 1 and run.contact_force.max() > 10


def test_all_that_takes_a_model_takes_laws(handout):
    """A law that is the device's own gives what the device gives, within its errors."""
    asked, made = (1500.0, 25.0), {}
    for name, laws in (("own", None), ("law", {"damping": linear_drag})):
        how = {"model": snapmap.Cosines(modes=3, laws=laws), "horizon": 0.0}
        shock = {"N": 1100.0, "f0": 1500.0, "C": 25.0}
        study = Study(handout, **how)
        designed = snapmap.design(study, "thickness", between=(2.0, 2.2), **shock)
        of_batch = snapmap.tolerance(study, {"thickness": "2 %"}, *asked, samples=8)
        made[name] = designed, of_batch.N_mean.item()
    (of_own, mean), (of_law, mean_of_law) = made.values()
    assert abs(of_own.value - of_law.value) < of_own.error + of_law.error
    assert mean_of_law == pytest.approx(mean, rel=1e-3)


@pytest.mark.long
def test_the_stress_under_laws_is_that_of_the_device_where_they_are_its_own(handout):
    """And that of a history; with a law of the force it is unknown."""
    device = batch([replace(handout, strength=450.0)])
    cells = to_cells(device, 0, np.array([1500.0, 900.0]), 1000.0, 25.0, 100.0).flat()
    models = [snapmap.Cosines(modes=3, laws=laws) for laws in (None, LINEAR, {"contact": hertz})]
    stress = [largest_stress(device, model, cells, Run(horizon=100.0)) for model in models]
    np.testing.assert_allclose(stress[1], stress[0], rtol=1e-6)
    run = snapmap.simulate(Study(handout, models[2], horizon=100.0), 900.0, 1000.0, 25.0)
    assert stress[2][1] == pytest.approx(run.stress.max().item(), rel=1e-4)
    with pytest.raises(ValueError, match=r"^device\.strength: does not work with these laws"):
        build_model(device, snapmap.Cosines(laws={"force": lambda x: x * (x - 8) * (x - 18)}))

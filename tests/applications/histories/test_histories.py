"""The work of the pulse: what it is, and by how much it differs with another step."""

import numpy as np
import pytest
import yaml
from small_results import make_history
from small_studies import THREE_COSINES, cases_of, changed, faults
from varied import alone, in_steps, varied

import snapmap
from snapmap.applications.histories import figure, history
from snapmap.applications.whole import load_config
from snapmap.figures import style
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.outcome import OUTCOMES, REPEATED_STEP
from snapmap.solver.settings import Run
from snapmap.study.study import Study
from studies import motion

CASES, SETTINGS = cases_of(__file__), Run(horizon=300.0)
ENERGIES = ("kinetic", "spring", "bending", "axial", "contact", "dissipated")


REFERENCE, CHEAP = {"model": "reference"}, {"model": {"name": "cosines", "modes": 3}}


def work_of(model, N, f0, C, settings=SETTINGS):
    cells = to_cells(model.device, 0, np.atleast_1d(N), f0, C, settings.horizon)
    return model.follow_once(cells, settings).pulse_work


@pytest.mark.parametrize("ratio", [0.3, 1.0, 1.6, 2.0])
def test_the_work_on_a_mass_alone_is_what_its_residual_swing_holds(handout, ratio):
    """Undamped, and too far from the beam to touch it: K/2 of the amplitude squared.

    After a versed sine of `ratio` of its periods a mass on a spring swings by
    N g/omega^2 sin(pi ratio)/(1 - ratio^2), and at ratio 1 by pi/2 of N g/omega^2.
    """
    omega, device = handout.own_frequency, varied(handout, gap=1e3)
    f0, shock = omega / (2 * np.pi * ratio), 50 * handout.gravity / omega**2
    swing = shock * (np.pi / 2 if ratio == 1 else np.sin(np.pi * ratio) / (1 - ratio**2))
    work = work_of(build_model(device, Cosines(modes=3)), 50.0, f0 * 1e6, 0.0)
    # The pulse also moves the beam, which weighs less by a factor of 160, by a thousandth of that.
    assert work == pytest.approx(device.spring * swing**2 / 2, rel=1e-4, abs=1e-4)


def test_the_largest_values_are_those_of_every_step_to_any_horizon(handout, monkeypatch):
    """Windows and what is kept do not matter; the snap ends the part before it within a step."""
    shot, model, device = (1100.0, 1500.0, 25.0), CHEAP["model"], varied(handout, damping=4e-3)
    studies = [Study(device, model, horizon=end) for end in (200.0, 1500.0)]
    short, long = (snapmap.simulate(study, *shot) for study in studies)
    study = Study(device, model=model, horizon=1500.0)
    extremes = history.extremes_of(study, *shot)._asdict()
    assert extremes == {key: long[key].item() for key in extremes}
    assert all(short[key] <= long[key] for key in extremes)
    assert short.stress_max_to_snap == long.stress_max_to_snap
    monkeypatch.setattr("snapmap.applications.histories.history.SAMPLES", 10**9)
    run = snapmap.simulate(Study(device, model, horizon=200.0), *shot)
    at_rest = run.interp(time=0)
    assert at_rest.w_mid == at_rest.z_mass == device.beam.rise
    assert at_rest.contact_force == at_rest.pulse_work == at_rest.acceleration == 0
    moved = run.z_mass.values - device.beam.rise
    ways = max(0, -moved.min()), max(0, moved.max())
    assert (run.toward_max.item(), run.away_max.item()) == pytest.approx(ways, rel=1e-12)
    assert run.contact_force_max == run.contact_force.max() and run.stress_max == run.stress.max()
    after = np.flatnonzero(run.w_mid <= run.second_equilibrium)[0]
    part = run.isel(time=slice(after - 1, after + 1))
    at_snap = np.interp(-run.second_equilibrium, -part.w_mid, part.stress)
    expected = max(run.stress.values[:after].max(), at_snap)
    assert run.stress_max_to_snap == pytest.approx(expected, rel=1e-12)
    w, stress = np.array([3.0, 1.0, -3.0]), np.array([1.0, 2.0, 10.0])
    assert history._stress_to(0.0, w, stress) == (4.0, True)  # a quarter of the way from 2 to 10
    assert history._stress_to(0.0, w, stress[[2, 0, 1]]) == (10.0, True)
    assert history._stress_to(-5.0, w, stress) == (10.0, False)


ENERGETIC = [(CHEAP, 700.0), (CHEAP, 1500.0), (REFERENCE, 1500.0)]
ENERGETIC.append(pytest.param(REFERENCE, 700.0, marks=pytest.mark.long))


@pytest.mark.parametrize(("asked", "N"), ENERGETIC)
def test_the_work_is_the_change_of_energy_and_the_losses(handout, fix_step, asked, N):
    device, asked = varied(handout, damping=1e-3, gap=0.2), asked | {"horizon": 100.0}
    fix_step(0.3)
    run = snapmap.simulate(Study(device, **asked), N, 2e3, 25.0)
    gained, work = sum(run[f"{kind}_energy"][-1] for kind in ENERGIES), run.pulse_work[-1].item()
    assert work == pytest.approx(gained.item(), rel=2e-3)
    cube = snapmap.sweep(Study(device, **asked), [N], [2e3], [25.0])
    if asked["model"] == "reference" and N > 1000:
        assert np.isnan(cube.pulse_work)  # its run ends at the snap, within the pulse
    else:
        assert cube.pulse_work.item() == pytest.approx(work, rel=1e-6)


@pytest.mark.parametrize(("contact", "modes"), [(40.0, 3), (40.0, 5), (np.inf, 3)])
def test_the_work_converges_with_order_two(handout, contact, modes):
    """Cells that never snap, where the motion is smooth."""
    device = varied(handout, contact=contact)
    model = in_steps(build_model(device, Cosines(modes=modes)), 0.2)
    works = [work_of(model.with_step(2.0**-k), [500.0, 700.0], 3e3, 25.0) for k in range(3)]
    first, second = abs(np.diff(works, axis=0))
    np.testing.assert_allclose(np.log2(first / second), 2, atol=0.2)


@pytest.mark.parametrize(("N", "f0", "C", "asked", "outcome"), CASES["runs"])
def test_the_snap_is_that_of_the_motion_shown(handout, monkeypatch, N, f0, C, asked, outcome):
    """To the curvature of w between two samples; the longer steps of a sweep snap at another."""
    monkeypatch.setattr("snapmap.applications.histories.history.SAMPLES", 10**9)
    device = varied(handout, stop_away=30.0, damping=4e-3) if asked != REFERENCE else handout
    run = snapmap.simulate(Study(device, **asked), N, f0, C)
    assert run.outcome == OUTCOMES.index(outcome)
    back = run.get("first_equilibrium")
    side, end = (1, run.second_equilibrium) if back is None else (-1, back)
    w, target = side * run.w_mid, side * end.item()
    of_rest, next_to_it = run.axial_force.values[:2]
    assert of_rest == pytest.approx(next_to_it, rel=1e-3, abs=1e-3)
    after = int(np.argmax(w.values <= target))
    assert np.isfinite(run.t_snap) == bool(after) == (outcome != "never")
    if after:
        ends = slice(after - 1, after + 1)
        own = np.interp(-target, -w[ends], run.time[ends])
        assert run.t_snap == pytest.approx(own, abs=5e-3 * run.time_step.item())
    assert asked != REFERENCE or run.t_snap == pytest.approx(434.8857, abs=5e-5)


def test_errors_cover_nine_of_ten_runs_in_a_quarter_of_the_step():
    """Random devices and shocks, from just above the threshold to 2.5 times it."""
    work, work_bar, snap, snap_bar, _ = np.concatenate(
        [motion.judged(np.random.default_rng([7, n]), modes=3) for n in range(2, 10)], axis=1
    )
    known = np.isfinite(snap_bar)
    assert known.sum() > 20
    for error, bar in ((work, work_bar), (snap, snap_bar)):
        assert np.mean((error <= bar)[known]) >= 0.9
        # The spread itself is no error.
        assert np.mean((error <= bar / history.SAFETY)[known]) < 0.9


def test_a_cube_says_by_how_much_another_step_differs(handout):
    axes = [0.0, 700.0, 1400.0], [1500.0, 6e3], [25.0]
    cube = snapmap.sweep(Study(handout, horizon=300.0, **CHEAP), *axes)
    model = build_model(handout, Cosines(modes=3))
    f0, N = (values.ravel() for values in np.meshgrid(cube.f0, cube.N, indexing="ij"))
    cells, struck = to_cells(handout, 0, N, f0, 25.0, 300.0), N > 0
    runs = [each.follow(cells, SETTINGS) for each in (model, model.with_step(REPEATED_STEP))]
    works, times = np.array([(run.pulse_work, run.t_snap) for run in runs]).swapaxes(0, 1)
    keys = "pulse_work", "work_error", "t_snap_error"
    work, error, time_error = (cube[key].values.ravel() for key in keys)
    np.testing.assert_array_equal(work, np.float32(works[0]))
    apart = np.float32(abs(works[1] - works[0])[struck] / works.max(axis=0)[struck])
    np.testing.assert_array_equal(error[struck], apart)
    np.testing.assert_array_equal(time_error, np.float32(abs(times[1] - times[0])))
    assert (cube.t_snap_error.isnull() == cube.t_snap.isnull()).all()


def curves_of(run):
    """The points of the lines in each of the three panels."""
    panels = figure.draw_history(style.double_column(height=4.2).subplots(3, sharex=True), run)
    return [[np.transpose(line.get_data()).tolist() for line in ax.lines] for ax in panels]


@pytest.mark.usefixtures("paper")
def test_a_figure_has_the_history_in_ms_and_multiples_of_g_and_marks_the_first_snap_if_seen():
    time, w = 0.01 * np.arange(6), [10, 0, -8, -12, -5, -12]
    panels = curves_of(make_history(*w, t_snap=22.5))
    (beam, mass, *lines), (force, *of_force), (shock, *of_shock) = panels
    for curve, values in ((beam, w), (mass, np.add(w, 1)), (force, 0 * time), (shock, 2000)):
        np.testing.assert_allclose(curve, np.transpose(np.broadcast_arrays(time, values)))
    snap = [[0.0225, 0], [0.0225, 1]]
    assert lines == [[[0, -9], [1, -9]], snap, [[0.0225, -9.0]]] and of_force == of_shock == [snap]
    assert [len(curves) for curves in curves_of(make_history(10, 0, -8.9))] == [3, 1, 1]


@pytest.mark.usefixtures("paper")
def test_a_caption_names_the_values_that_a_cell_has_in_place_of_the_devices_own():
    drawn = style.double_column(height=4.2)
    changed = make_history(10, 0, -12).assign_coords(temperature=-33.0, device="b2")
    figure.draw_history(drawn.subplots(3, sharex=True), changed)
    words = drawn.legends[0].get_title().get_text()
    assert words.startswith("device b2, temperature −33 °C, $C$ = 0.025 ") and "$N$ = 1000" in words
    changed["work_error"], changed["t_snap_error"] = 0.0123, 0.05
    figure.draw_history((other := style.double_column(height=4.2)).subplots(3), changed)
    words = other.legends[0].get_title().get_text().splitlines()[-1]
    errors = "error by the time step: 1.2 % of the work of the pulse, 0.05 µs of the time of snap"
    assert words == errors


@pytest.mark.parametrize(("changes", "cells", "expected"), CASES["cells"])
def test_a_cell_has_what_it_writes_and_else_what_the_study_says_alone(changes, cells, expected):
    document = changed(yaml.safe_load(THREE_COSINES), **CASES["study"] | changes, histories=cells)
    if isinstance(expected, str):
        assert faults(document) == [expected]
    else:
        (cell,) = load_config(document).requests["histories"]
        assert [cell.name, cell.f0, cell.C, cell.changes] == expected
        assert cell.device.beam.thickness == cell.changes.get("thickness", 2.0)


def test_a_history_has_stops_blows_forces_and_thousands_of_instants(handout):
    device = varied(handout, gap=1.0, stop_toward=30.0, stop_away=20.0)
    run = snapmap.simulate(Study(device, **CHEAP, horizon=50.0), 700.0, 2e3, 25.0)
    places = run.stop_toward, run.stop_away, run.z_mass[0], run.gravity
    assert [place.item() for place in places] == pytest.approx([-19.0, 31.0, 11.0, 9.81e-6])
    assert 4000 <= run.time.size < 8000
    study = Study(handout, **CHEAP, horizon=100.0, pulse={"train": CASES["train"]})
    runs = [snapmap.simulate(study, N, None, 25.0) for N in (900.0, 1200.0)]
    assert [(run.blow.item(), run.t_snap.notnull().item()) for run in runs] == [(0, 0), (1, 1)]
    pushed = Study(alone(handout, 2.0, damping=4e-3), **CHEAP, horizon=50.0)
    run = snapmap.simulate(pushed, 30.0, 2e3, 0.0)
    assert run.midpoint_force.max().item() == pytest.approx(60.0) and "acceleration" not in run


def test_a_mass_that_flies_beyond_five_rises_on_a_side_without_a_stop_is_warned_of(handout):
    one = varied(handout, stop_away=20.0)
    assert [history.free_travel(device, 30.0, 70.0) for device in (handout, one)] == [7.0, 3.0]
    assert history.free_travel(varied(one, stop_toward=20.0), 30.0, 70.0) == 0.0
    with pytest.warns(UserWarning, match="the mass travels up to 7.67 times the rise, ") as warned:
        snapmap.simulate(Study(handout, **CHEAP, horizon=0.0), 20_000.0, 1e3, 25.0)
    assert warned[0].filename == __file__ and history.warn_of_travel(5.0) is None
    assert history.NEAR.tolist() == pytest.approx(np.linspace(0.99, 1.01, 21))

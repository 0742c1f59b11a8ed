"""The static path against closed forms, and the static threshold against slow pulses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline
from scipy.optimize import root
from small_results import drawn
from small_studies import cases_of
from varied import alone, varied

import snapmap
from snapmap.applications.statics import application, figure
from snapmap.beam.limit_loads import static_threshold
from snapmap.figures import style
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import Run
from snapmap.thresholds.probe import Probe, lowest_snap


@pytest.fixture(scope="module")
def path(handout):
    return snapmap.statics(handout)


@pytest.mark.equation(18, 20, 21)
def test_the_path_has_the_exact_shapes_energies_forces_and_stiffness(path, handout):
    """F = 0 in both shapes and at the saddle w_s = -rise/3; 192 EI/L^3 at first, then straight."""
    guided = path.sel(branch="guided")
    way, force, energy = (guided[key].values for key in ("displacement", "force", "energy"))
    crossing = np.flatnonzero(np.diff(np.sign(force[1:]))) + 1
    second = 10 - handout.beam.second_equilibrium
    np.testing.assert_allclose(way[crossing], [40 / 3, second], rtol=5e-3)
    np.testing.assert_allclose(energy[crossing], [486.805, 385.962], rtol=1e-4)
    assert (path.saddle, path.barrier) == pytest.approx((-10 / 3, 486.805), rel=1e-5)
    assert way[0] == force[0] == energy[0] == 0
    assert (path.largest_force, path.least_force) == pytest.approx((70.67, -32.54), abs=0.01)
    assert way[np.argmax(force)] == pytest.approx(2.349, abs=2e-3)
    assert way[np.argmin(np.where(way < 19, force, 0))] == pytest.approx(18.39, abs=0.01)
    straight = np.polyfit(way[410:790], force[410:790], 1)
    assert straight[0] == pytest.approx(-6.434, abs=1e-3)
    np.testing.assert_allclose(np.polyval(straight, way[410:790]), force[410:790], atol=1e-9)


def free(device, Q, imperfection):
    return varied(device, free=1.0, thickness=device.beam.rise / Q, imperfection=imperfection)


CLOSED = {5: (386.1, 2.5225), 6: (389.665, -1.0424), 12: (395.596, -6.9736), 20: (396.839, -8.2164)}


@pytest.mark.parametrize("Q", CLOSED)
def test_a_free_beam_tilts_at_the_closed_form(handout, Q):
    """At N = 80.76 EI/L^2 the symmetric part of all modes alone bears the force: a quadratic."""
    device = free(handout, Q, 1e-9)
    statics, unit = snapmap.statics(device), device.beam.stiffness_unit * device.beam.rise
    forces = statics.largest_force / unit, statics.least_force / unit
    assert forces == pytest.approx(CLOSED[Q], abs=1e-3)
    assert (statics.barrier > 0) == (forces[1] < 0)
    assert statics.force.sel(branch="guided").max() > statics.largest_force


@pytest.mark.equation(6)
def test_the_energy_is_the_work_of_the_force(path, handout):
    tilted = snapmap.statics(free(handout, 6, 0.03)).sel(branch="tilted")
    for branch in (*[path.sel(branch=name) for name in path.branch.values], tilted):
        work, k = np.zeros(1), np.arange(branch.point.size // 3)
        for part in np.split(branch[["displacement", "force"]].to_array().values, 3, axis=1):
            rate = CubicSpline(k, part[0])(k, 1) * part[1]
            work = np.append(work, work[-1] + CubicSpline(k, rate).antiderivative()(k))
        np.testing.assert_allclose(branch.energy, work[1:], atol=0.02)


PUSHED = {"damping": 4e-3, "free": 1.0, "imperfection": 0.05}
"""With tilt: of a perfect guided beam under a force nothing wakes the second mode but time."""
CASES = cases_of(__file__)


def lowest_slow(device, f0, C, direction="+z", start="first"):
    """The threshold of a slow pulse over the static one."""
    static = static_threshold(device, back=start == "second")
    rows, reach = to_rows(0, f0, C, 0, make_shocks("versed sine", direction).pulses), (0.8, 1.2)
    model, reach = build_model(device, Cosines(modes=3)), tuple(static * np.array(reach))
    probe = Probe(model, rows, Run(horizon=0.0, start=start))
    return lowest_snap(probe, reach, 1e-4).item() / static


@pytest.mark.parametrize("values", CASES["slow"])
def test_slow_pulses_tend_to_the_static_threshold(handout, values):
    """A soft spring lets go at the top of the path, a stiff one where the beam leaves the mass."""
    device = varied(handout, **values)
    f0 = device.own_frequency / (2 * np.pi * 80) * 1e6
    assert lowest_slow(device, f0, 400.0) == pytest.approx(1, rel=4e-3)


@pytest.mark.parametrize("force", [0.0, 1.0])
def test_slow_pulses_on_a_beam_alone_tend_to_its_static_thresholds_there_and_back(handout, force):
    device = alone(handout, force, **PUSHED)
    assert lowest_slow(device, 500.0, 0.0) == pytest.approx(1, rel=2e-3)
    device = varied(device, residual_stress=-60.0)
    assert lowest_slow(device, 500.0, 0.0, "-z", "second") == pytest.approx(1, rel=2e-3)


def forces_held(beam, ways):
    """Forces that hold the midpoint of a guided beam so far from its first shape, uN, by Newton.

    Each follows from the one before, in amplitudes of (1 - cos(2 n pi x/L))/2, n up to 40.
    """
    n, made = np.arange(1, 41), np.zeros(40)
    made[:2] = beam.rise, beam.rise * beam.cosine_2
    square, axial = (2 * np.pi * n / beam.span) ** 2, beam.youngs_modulus * beam.area
    slope = beam.span / 8 * square
    bending, at_middle = beam.bending_stiffness * square * slope, n % 2

    def residual(unknown, way):
        a, force = unknown[:-1], unknown[-1]
        pull = axial * (slope @ a**2 - slope @ made**2) / (2 * beam.span) * slope
        loads = bending * (a - made) + pull * a + force * at_middle
        change = np.diag(bending + pull) + axial / beam.span * np.outer(slope * a, slope * a)
        jacobian = np.block([[change, at_middle[:, np.newaxis]], [at_middle, 0.0]])
        return np.append(loads, at_middle @ a - beam.rise + way), jacobian

    forces, unknown = [], np.append(made, 0.0)
    for way in ways:
        solved = root(residual, unknown, (way,), jac=True, tol=1e-12)
        assert solved.success
        unknown = solved.x
        forces.append(unknown[-1])
    return np.array(forces)


@pytest.mark.parametrize("cosine_2", [0.005, 0.02, 0.05, 0.08, 0.1])
def test_a_guided_beam_with_a_second_cosine_is_as_stiff_as_its_energy_says(handout, cosine_2):
    device = varied(handout, cosine_2=cosine_2, contact_at=-5.0)
    path, ways = snapmap.statics(device), np.linspace(0, 20, 401)
    forces, guided = forces_held(device.beam, ways), path.sel(branch="guided")
    held = np.interp(ways, guided.displacement, guided.force)
    np.testing.assert_allclose(held, forces, atol=0.05)
    extremes = path.largest_force, path.least_force
    assert extremes == pytest.approx((forces.max(), forces.min()), abs=0.01)
    assert path.hold_force == pytest.approx(max(0.0, -forces[300]), abs=5e-3)


def test_a_force_that_is_not_known_does_not_hold_nothing(handout, monkeypatch):
    name = "snapmap.applications.statics.statics.largest_force"
    monkeypatch.setattr(name, lambda *_: np.array(np.nan))
    assert np.isnan(snapmap.statics(replace(handout, contact_at=-5.0)).hold_force)


@pytest.mark.parametrize("rise", [8.0, 10.0, 13.0])
def test_a_free_beam_without_stress_has_the_rise_with_which_it_was_made(handout, rise):
    found = snapmap.statics(varied(handout, rise=rise, free=True, imperfection=0.01))
    assert found.rise.item() == pytest.approx(rise, rel=1e-6)


def held_straight(beam, n):
    """Both forces and ways, over their units, at the axial force (n/L)^2 EI: a beam-column."""
    x, Q, made = np.linspace(0, 0.5, 2001), beam.rise / beam.thickness, np.pi * np.pi / 2
    bow = -2 * np.pi**2 / (4 * np.pi**2 - n * n)
    # w = bow cos(2 pi x) + c0 + c1 x + c2 cos(n x) + c3 sin(n x) on half the span
    ends = np.array([[1, 0, 1, 0], [0, 1, 0, n], [0, 1, -np.sin(n / 2) * n, np.cos(n / 2) * n]])
    shear = n**3 * np.array([0, 0, np.sin(n / 2), -np.cos(n / 2)])
    parts, slopes, middles = ((-bow, 0, 0, 0), (0, 0, 0, 0.5)), [], []
    solved = np.linalg.solve([*ends, shear], np.transpose(parts)).T
    for c, part in zip(solved, (bow, 0), strict=True):
        wave = n * (c[3] * np.cos(n * x) - c[2] * np.sin(n * x))
        slopes.append(wave + c[1] - 2 * np.pi * part * np.sin(2 * np.pi * x))
        middles.append(c @ [1, 0.5, np.cos(n / 2), np.sin(n / 2)] - part)
    u, v = slopes
    square, cross, rest = (12 * Q * Q * simpson(a * b, x=x) for a, b in ((v, v), (u, v), (u, u)))
    rest += n * n - 6 * Q * Q * made - 4 * np.pi**2 * beam.compression
    force = (-cross + np.array([-1, 1]) * np.sqrt(cross**2 - square * rest)) / square
    return force, 1 - middles[0] - force * middles[1]


@pytest.mark.equation(3)
@pytest.mark.parametrize(
    ("Q", "stress", "most"), [(3.1, 0.0, 4.6), (5.0, 0.0, 8.4), (6.2, -3.0, 8.8), (9.0, -5.0, 9.0)]
)
def test_a_beam_without_its_second_mode_follows_the_closed_form_beyond_the_third(
    handout, Q, stress, most
):
    device = varied(handout, thickness=handout.beam.rise / Q, residual_stress=stress)
    found, beam = snapmap.statics(device), device.beam
    path, top = found.sel(branch="unbranched"), found.force.max().item()
    ways = 1 + (path.displacement.values - found.rise.item()) / beam.rise
    points = np.stack([ways, path.force.values / top])
    assert np.count_nonzero(abs(points[1]) < 1e-9) <= 1
    for n in np.pi * np.array([3.0, 3.9, 4.6, 5.7, 6.2, 7.1, 8.4, 8.8]):
        if n > most * np.pi:
            continue
        for force, way in zip(*held_straight(beam, n), strict=True):
            exact = np.array([way, force * beam.stiffness_unit * beam.rise / top])
            steps, to = np.diff(points), exact[:, np.newaxis] - points[:, :-1]
            length = np.maximum(np.sum(steps**2, axis=0), 1e-30)
            share = np.clip(np.sum(to * steps, axis=0) / length, 0, 1)
            assert np.hypot(*(to - share * steps)).min() < 1e-3


@pytest.mark.usefixtures("paper")
def test_figures_have_force_and_energy_over_the_way_and_mark_both_shapes_and_the_saddle(path):
    second, saddle = 10 - path.second_equilibrium, 10 - path.saddle
    panels = [(figure.draw_force_displacement, "force", (0, 0, 0))]
    panels.append((figure.draw_energy, "energy", (0, 385.962, 486.805)))
    for draw, key, heights in panels:
        ax, real = drawn(draw, path), path[key].sel(branch="guided").values
        reach = (real.max() - real.min()) / 2
        assert ax.get_ylim() == pytest.approx((real.min() - reach, real.max() + reach))
        for text, (words, *at) in zip(ax.texts, CASES["texts"][key], strict=True):
            assert text.get_text() == words and text.xy == pytest.approx(at, rel=1e-3)
        *paths, stable, unstable = (line.get_xydata().T for line in ax.lines[:4])
        for branch, points in zip(("unbranched", "guided"), paths, strict=True):
            expected = path.sel(branch=branch)
            np.testing.assert_array_equal(points, [expected.displacement, expected[key]])
        np.testing.assert_allclose(stable, [[0, second], heights[:2]], rtol=1e-4)
        np.testing.assert_allclose(unstable, [[saddle], heights[2:]], rtol=1e-4)
        # A path that is not physical is cut off only beyond half the heights of the real one.
        less = path[key].where(path.branch == "guided", 1.4 * path[key].sel(branch="guided"))
        for shown, count in ((path[key], 1), (less, 0)):
            labels = [line.get_label() for line in drawn(draw, path.assign({key: shown})).lines]
            assert sum("cut off" in label for label in labels) == count


@pytest.mark.usefixtures("paper")
def test_a_beam_that_returns_by_itself_has_one_stable_shape_and_no_barrier(handout):
    figure.draw(page := style.double_column(3.6), snapmap.statics(free(handout, 5, 1e-9)))
    force, energy = page.axes
    for ax in page.axes:
        marked = [line.get_xydata().tolist() for line in ax.lines if line.get_marker() == "o"]
        assert marked == [[[0, 0]]]
    assert len(force.texts) == 2 and not energy.texts
    assert force.get_position().height == pytest.approx(1.5 * energy.get_position().height)


@pytest.mark.parametrize(("device", "names", "paths"), CASES["files"])
def test_each_device_has_a_file_of_its_name_if_there_may_be_several(device, names, paths):
    devices = lambda: dict.fromkeys(names)  # noqa: E731
    study = SimpleNamespace(device=device, devices=devices, model=SimpleNamespace(laws=None))
    assert application.outputs(study)["statics"] == [f"results/{path}.nc" for path in paths]
    assert [*application.figures(study)] == paths
    for force in (None, "own"):
        study.model.laws = SimpleNamespace(force=force)
        assert bool(application.outputs(study)) == (force is None)

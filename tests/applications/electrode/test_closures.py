"""What an electrode sees: closed forms, and an integration of the handout's equations apart."""

from dataclasses import replace
from math import fsum, log, pi, sqrt
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
import yaml
from scipy.integrate import solve_ivp
from small_results import make_verdict
from small_studies import THREE_COSINES, TINY, cases_of, changed, faults
from varied import varied

import snapmap
from snapmap.applications.electrode import closures
from snapmap.applications.electrode.closures import CLOSING, Closures, closures_of, passages
from snapmap.applications.electrode.required import DEMANDS, judge_closing
from snapmap.applications.histories.history import observed_of
from snapmap.applications.whole import load_config
from snapmap.solver.adaptive import choose_model
from snapmap.solver.cells import Cells, no_observations, to_cells
from snapmap.solver.options import Cosines
from snapmap.solver.settings import Run
from snapmap.study.study import Study
from snapmap.sweeps.cube import sweep as core_sweep
from snapmap.values.faults import Faults

CASES = cases_of(__file__)
MODEL = {"name": "cosines", "modes": 3}
CELLS = [(1000.0, 1500.0), (1500.0, 3000.0), (1800.0, 9000.0)]
HORIZON = 150.0


@pytest.fixture(scope="module")
def device(handout):
    """The handout's, its ringing damped, over an electrode."""
    return varied(handout, damping=4e-3, contact_at=-5.0)


def test_a_bouncing_ball_closes_in_a_geometric_series():
    """Dropped from h, it is up to `level` around each impact, for sqrt(v^2 - 2 g level) apart."""
    g, h, e, level, end = 2.0, 9.0, 0.7, 0.1, 30.0
    speeds = sqrt(2 * g * h) * e ** np.arange(60)  # at the impacts
    impacts = np.cumsum([sqrt(2 * h / g), *(2 * speeds[1:] / g)])
    time = np.arange(0, end, 1e-3)
    n = np.searchsorted(impacts, time, side="right")
    since = time - np.append(0.0, impacts)[n]
    flown = np.where(n == 0, h, np.append(0.0, speeds)[n] * e * since) - g * since**2 / 2
    _, places = passages(np.maximum(0.0, flown)[:, np.newaxis], np.array([level]))
    openings = int(log(level / h) / (2 * log(e)))  # e^2n h > level
    under = [(v - sqrt(v * v - 2 * g * level)) / g for v in speeds[: openings + 1]]
    above = fsum(2 * v / g - 2 * t for v, t in zip(speeds[1:], under[1:], strict=False))
    first = impacts[0] - under[0]
    expected = first, under[0] + under[1], openings, 1 - above / (end - first)
    assert closures_of(1e-3 * places, False, end) == pytest.approx(expected, abs=1e-5)


def test_a_damped_swing_passes_zero_at_its_quarter_turns_with_order_two():
    errors = []
    for step in (0.02, 0.01, 0.005):
        time = step * (np.arange(round(3 / step)) + 0.3)
        w = np.exp(-0.8 * time) * np.cos(2 * pi * time)
        instants = step * (passages(w[:, np.newaxis], np.zeros(1))[1] + 0.3)
        errors.append(abs(instants - (0.25 + 0.5 * np.arange(6))).max())
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.5)
    expected = Closures(0.25, 0.5, 3, 1.5 / 2.75)
    assert closures_of(instants, False, 3.0) == pytest.approx(expected, abs=1e-4)
    assert closures_of([0.5, 2.0], True, 3.0) == (0.0, 0.5, 1, 0.5)
    assert closures_of([], True, 3.0) == (0.0, 3.0, 0, 1.0)
    assert np.isnan(closures_of([], False, 3.0)).all()


def integrated(device, N, f0, C):
    """Instants at which w(L/2) passes the electrode: (2), (4) in cosines, by DOP853."""
    beam, n = device.beam, np.array([1, 2, 3])
    L, share = beam.span, 2 * n * pi / beam.span
    density, axial = beam.density * beam.thickness * beam.depth, 150e3 * beam.thickness * beam.depth
    EI = axial * beam.thickness**2 / 12
    bending, geometric = EI * L / 2 * share**4, L / 2 * share**2
    inverse = np.linalg.inv(density * L * (np.ones((3, 3)) + np.eye(3) / 2))
    start, middle = np.array([beam.rise / 2, 0, 0]), np.array([2, 0, 2])
    odd = np.arange(5, 2001, 2)  # left out: their flexibility at twice the first load, N_1
    left_out = (4 / (bending[0] * odd**2 * (odd**2 - 2.0))).sum()
    stiffness = 1 / (1 / device.contact + left_out)

    def force(state):
        return stiffness * max(0.0, middle @ state[:3] - state[3])

    def electrode(t, state):
        return middle @ state[:3] - left_out * force(state) - device.contact_at

    def rate(t, state):
        c, z, v, z_rate = state[:3], state[3], state[4:7], state[7]
        a = N * device.gravity / 2 * (1 - np.cos(2 * pi * f0 * t)) if t < 1 / f0 else 0.0
        squeeze = axial / (2 * L) * (geometric @ (start**2 - c**2))
        push = -bending * (c - start) + squeeze * geometric * c - density * L * a
        beams = inverse @ (push - middle * force(state)) - beam.damping * v
        mass = (force(state) - C * z_rate - device.spring * (z - beam.rise)) / device.mass - a
        return np.concatenate([v, [z_rate], beams, [mass]])

    span, options = (0, 1 / f0 + HORIZON), {"method": "DOP853", "rtol": 1e-7, "atol": 1e-7}
    state = np.concatenate([start, [beam.rise], np.zeros(4)])
    run = solve_ivp(rate, span, state, events=electrode, max_step=2.0, **options)
    return closures_of(run.t_events[0].tolist(), False, span[1])


@pytest.mark.equation(2, 4)
@pytest.mark.parametrize(("N", "f0"), CELLS)
def test_closures_are_those_of_the_handouts_equations(device, N, f0):
    study = Study(device, model=MODEL, horizon=HORIZON)
    seen, expected = observed_of(study, N, f0, 25.0)[1], integrated(device, N, f0 * 1e-6, 25.0)
    for key in ("t_closed", "closed_for", "openings"):
        assert abs(seen[key] - getattr(expected, key)) <= seen[f"{key}_error"], key
    assert seen["t_closed_error"] < 0.1
    # The share's own error may cancel: it cannot exceed that of its instants over the time.
    instants = seen["t_closed_error"] + seen["closed_for_error"]
    assert abs(seen["closed_share"] - expected.closed_share) <= instants / HORIZON


def test_a_cube_has_what_histories_have_and_else_nothing_new(device):
    how = {"model": MODEL, "horizon": HORIZON}
    asked = {"f0": [1500.0], "C": [25.0]}
    study, bare = (Study(each, **how) for each in (device, replace(device, contact_at=-np.inf)))
    cube, other = (snapmap.sweep(each, [700, 1000, 1100], **asked) for each in (study, bare))
    alone = snapmap.sweep(study, [1000], **asked)
    run = snapmap.simulate(study, 1000, 1500, 25)
    for key in CLOSING:
        assert cube[key].sel(N=1000).item() == alone[key].item() == np.float32(run[key])
    assert {*cube} - {*other} == {*CLOSING}
    assert {*core_sweep(study, 700, [1500.0], [25.0])} == {*other}
    assert all((cube[key].values == other[key].values).all() for key in ("outcome", "well"))
    assert (cube.t_closed[..., 1:] < cube.t_snap[..., 1:]).all() and np.isnan(cube.t_closed[..., 0])
    fallen = run.isel(time=slice(0, int(run.w_mid.values.argmin()) + 1))
    first = np.interp(5.0, -fallen.w_mid, fallen.time)
    assert run.t_closed == pytest.approx(first, abs=0.01)


def test_a_window_has_a_closure_before_its_end_and_none_after_it(device):
    model, settings = choose_model(device, Cosines(modes=3)).levels[-1], Run(horizon=HORIZON)
    cells = to_cells(device, [0] * 9, np.arange(1000, 1900, 100), 1500.0, 25.0, HORIZON)
    closed = lambda end: closures.follow_closures(model, cells, end, settings)["t_closed"]  # noqa: E731
    first = closed(cells.t_end)
    assert (closed(first + 1e-9) == first).all() and np.isnan(closed(first - 1e-9)).all()


class Level(NamedTuple):
    """A level of a model of three; the last of its devices has no electrode."""

    number: int = 0
    step: float = 1.0
    device = np.rec.array([(-5.0,), (-3.0,), (-np.inf,)], [("contact_at", float)])
    barrier = SimpleNamespace(first=12.0, midpoint=-16.0)
    levels = property(lambda self: [Level(number) for number in range(3)])
    with_step = lambda self, factor: self._replace(step=factor)  # noqa: E731
    split = lambda self, device: [(np.full(device.shape, True), self)]  # noqa: E731


@pytest.mark.parametrize("start", ["first", "second"])
def test_a_cell_is_followed_again_as_it_was_decided_until_it_stays_above(monkeypatch, start):
    """A failed one is not followed, and one that snaps is at the finest level."""

    def follow(part, cells, window, settings):
        how = window, part.step + 0 * window, part.number + 0 * window, cells.amplitude
        return dict.fromkeys(CLOSING, np.nan) | dict(zip(Closures._fields, how, strict=True))

    monkeypatch.setattr(closures, "follow_closures", follow)
    table = np.array(CASES["again"], float).reshape(2, -1, 9)
    which, level, halvings, t_snap, well, t_settled, error, *expected = np.moveaxis(table, -1, 0)
    seen = no_observations(which.shape)._replace(t_snap=t_snap, well=well, t_settled=t_settled)
    is_first, halvings = start == "first", halvings.astype(np.int8)
    seen = seen._replace(energy_error=error, halvings=halvings, level=level.astype(np.int8))
    if not is_first:
        seen, expected[1] = seen._replace(level=None), np.where(t_snap > 0, 2, 0 * expected[1])
    which, amplitude = which.astype(int), 1.0 + np.arange(which.size).reshape(which.shape)
    cells = Cells(which, 0 * which, *[amplitude] * 3, 100.0 + 0 * amplitude, ())
    found = closures.closures_again(Level(), cells, seen, Run(start=start))
    known = np.isfinite(expected[0])
    expected = np.where(is_first, expected[0], 100.0), 0.5**halvings, expected[1], amplitude
    for key, values in zip(Closures._fields, expected, strict=True):
        assert found[key].dtype == np.float32
        np.testing.assert_allclose(found[key], np.where(known, values, np.nan), rtol=1e-6)


def test_devices_of_a_study_have_an_electrode_or_none():
    document = yaml.safe_load(TINY)
    plain = document.pop("device")
    document["devices"] = {"plain": plain, "closing": plain | {"contact_at": "-5 um"}}
    with pytest.raises(Faults, match=r"^device\.contact_at: only some devices have it"):
        load_config(document)


def test_an_electrode_is_held_by_the_straight_line_of_the_statics(device):
    """At N = 4 N_1 the flexibility of all odd modes adds up: F = 8 EI/(pi^2 L^3) (2 pi)^4/2 w."""
    hold = lambda at: snapmap.statics(replace(device, contact_at=at)).hold_force  # noqa: E731
    beam = device.beam
    EI = 150e3 * beam.depth * beam.thickness**3 / 12
    slope = 8 / pi**2 * EI / 2 * (2 * pi) ** 4 / beam.span**3
    for at in (-4.0, -5.0, -6.0):
        assert hold(at) == pytest.approx(slope * (-beam.rise / 3 - at), rel=1e-7)
    assert hold(beam.second_equilibrium) == pytest.approx(0, abs=1e-3)
    assert hold(0.0) == hold(-9.6) == 0
    with pytest.raises(ValueError, match=r"^contact_at: 12 um is not below the midpoint"):
        hold(12.0)


@pytest.mark.parametrize(("required", "changes", "verdict"), CASES["judged"])
def test_a_requirement_of_the_electrode_is_met_beyond_its_error(required, changes, verdict):
    closing = {"t_closed": 100.0, "t_closed_error": 1.0, "closed_for": 50.0}
    closing |= {"closed_for_error": 1.0, "openings": 2.0} | changes
    met, failed = (make_verdict(verdict=word, more=closing) for word in ("met", "failed"))
    judged = judge_closing(met, **required)
    assert judged.verdict == verdict and len(judged.more) == len(closing) + len(required)
    assert judge_closing(failed, **required).verdict == "failed"
    within, least = (required.get(key, np.nan) for key in ("closes_within", "stays_closed"))
    margins = [judged.more.get(key, np.nan) for key in ("closes_margin", "stays_margin")]
    assert margins == pytest.approx([within / closing["t_closed"], 50.0 / least], nan_ok=True)
    if np.isnan(closing["t_closed"]) and required:
        unclear = judge_closing(replace(met, verdict="unclear"), **required)
        assert unclear.verdict == "unclear"


@pytest.mark.parametrize(("required", "place", "line"), CASES["asked"])
def test_a_closing_needs_an_electrode_and_a_shock_that_trips(required, place, line):
    """It asks for an arrival, as it says itself how long the beam stays."""
    shock = {"name": "a", "N": 1500, "f0": "1 kHz", "snaps": True, "shape": "half sine"} | required
    more = {"requirements": [shock], "device__contact_at": place}
    document = changed(yaml.safe_load(THREE_COSINES), **CASES["study"], **more)
    if line:
        (fault,) = faults(document)
        assert fault == line
    else:
        (asked,) = load_config(document).requests["requirements"]
        assert asked.snaps == ("any" if shock["snaps"] == "any" else "arrives")
        assert asked.demands == {key: 1000.0 for key in required if key in DEMANDS}


def test_a_sheet_has_the_closures_of_each_requirement_that_closes(study):
    more = {"t_closed": 123.4567, "closed_for": 7.0, "openings": 2.0, "closed_share": 0.5}
    more |= {f"{key}_error": 0.26 for key in more}
    words, table = closures.sections(study, [make_verdict(more=more), make_verdict()])
    assert words == "The electrode, to 0.3 ms after a shock:\n"
    first, *_, share = table.splitlines()[2:]
    assert first.startswith("| first closure | 123.5 us | 0.3 us | drop, half sine +z")
    assert share.startswith("| share of the time since then closed | 0.5 | 0.3 | drop, ")
    assert closures.sections(study, [make_verdict()]) == []

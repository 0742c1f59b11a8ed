"""Thresholds of samples that share a lattice, and their levels, of models with known thresholds."""

from types import SimpleNamespace

import numpy as np
import pytest
from known_model import STAYS, Known
from small_studies import cases_of

from snapmap.device.device import batch
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.cells import to_rows
from snapmap.solver.options import Auto, Cosines
from snapmap.solver.outcome import REPEATED_STEP
from snapmap.solver.settings import FIRST, Run
from snapmap.study.shock import Shock
from snapmap.thresholds import population
from snapmap.thresholds.population import Batch, Choice, _expected, _from_below
from snapmap.thresholds.probe import Probe

CASES = cases_of(__file__)
VALUES = {key: np.array(column) for key, column in CASES["values"].items()}
SETTINGS = Run()


@pytest.fixture
def limits(monkeypatch):
    """A static threshold of 12 from the first shape, and nearly no bound by energy."""
    static = {False: np.array([12.0]), True: np.array([0.1])}
    monkeypatch.setattr(population, "static_threshold", lambda device, back: static[back])
    monkeypatch.setattr(population, "least_amplitudes", lambda model, rows, start: 0.01)


@pytest.mark.usefixtures("limits")
@pytest.mark.parametrize(("ends", "start", "first", "is_ragged"), CASES["nominal"])
def test_a_nominal_threshold_is_sought_from_statics_up(handout, ends, start, first, is_ragged):
    probe = Probe(Known(batch([handout]), ends), to_rows(0, 1.0, 3.6), Run(start=start))
    N, ragged = population.nominal_thresholds(probe, 1e-4)
    assert ragged.tolist() == [is_ragged]
    assert [first * 7.2] == pytest.approx(N, rel=1e-4, nan_ok=True) and not first * 7.2 > N


@pytest.mark.parametrize(("ends", "nominal", "first", "is_ragged"), CASES["samples"])
def test_thresholds_of_samples_are_places_of_one_lattice(handout, ends, nominal, first, is_ragged):
    deviations = np.random.default_rng(1).normal(0, 0.01, (200, 2))
    C = np.exp(deviations @ [1.0, -0.5])
    rows = to_rows(0, [1.0, 2.0], C[:, np.newaxis])
    probe = Probe(Known(batch([handout]), ends), rows, SETTINGS)
    nominal = np.array([2 * nominal, np.nan])
    N, ragged = population.thresholds_of_samples(probe, deviations, nominal, 1e-3)
    N, lost = N.T
    assert np.isnan(lost).all() and ragged.tolist() == [is_ragged, False]
    assert (np.isnan(N) if np.isnan(first) else abs(N / (2 * first * C) - 1.0005) < 6e-4).all()
    steps = np.log(N / (nominal[0] / 30)) / np.log1p(1e-3)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


@pytest.mark.parametrize(("changes", "start", "found"), CASES["from_below"])
def test_the_first_place_of_a_ragged_row_is_sought_from_below(changes, start, found):
    label = lambda _, places: np.searchsorted(changes, places, "right") % 2 == 1  # noqa: E731
    place = _from_below(label, np.zeros(1, int), np.array([start]), 300, 5)
    assert place.tolist() == [found]


def test_samples_are_predicted_by_a_line_or_if_there_are_enough_by_a_quadratic():
    """Of three values there are enough from twenty on; a row without a threshold has the mean."""
    known, new = np.split(np.random.default_rng(3).normal(size=(27, 3)), [20])
    bend = np.arange(9.0).reshape(3, 3) / 10

    def N_of(x):
        lines = 2 + x @ [0.1, -0.2, 0.3]
        return np.exp(np.column_stack([lines, lines + np.einsum("ni,nj,ij->n", x, x, bend)]))

    for some, exact in ((known, [True, True]), (known[1:], [True, False])):
        N, least = _expected(new, some, N_of(some))
        assert np.isclose(N, N_of(new), rtol=1e-6).all(axis=0).tolist() == exact
        shares = N_of(some) / _expected(some, some, N_of(some))[0]
        np.testing.assert_allclose(least, shares.min(axis=0))
    lost, filled = N_of(known), N_of(known)
    lost[4], filled[4] = np.nan, np.exp(np.log(np.delete(filled, 4, axis=0)).mean(axis=0))
    np.testing.assert_allclose(_expected(new, known, lost)[0], _expected(new, known, filled)[0])


@pytest.mark.usefixtures("limits")
@pytest.mark.parametrize("rows", CASES["levels"])
def test_a_row_takes_the_cheapest_level_that_keeps_the_tolerance(handout, monkeypatch, rows):
    auto, (*errors, _, _) = Auto(), zip(*rows, strict=True)
    levels = [Known(batch([handout]), off=auto.tolerance * np.array(off)) for off in errors]
    made = SimpleNamespace(**dict(zip(("base", "check", "top"), levels, strict=True)))
    monkeypatch.setattr(population, "choose_model", lambda device, chosen, start: made)
    f0 = np.arange(1.0, 1 + len(rows))
    choices = population.choose_levels(handout, auto, to_rows(0, f0, 5.0 / f0), SETTINGS)
    chosen = [[(c.name, c.step) for c in choices if c.rows[i]] for i in range(f0.size)]
    assert chosen == [[tuple(row[-2:])] for row in rows]
    (alone,) = population.choose_levels(handout, Cosines(), to_rows(0, f0, 1.0), SETTINGS)
    assert alone.rows.all() and alone.of(levels[0]) == levels[0]


class TestBatch:
    """Four samples, of which one has no second shape; rows of two f0 and two C."""

    rows = to_rows(0, [1.0, 1.0, 2.0, 2.0], [2.0, 4.0, 2.0, 4.0])

    @pytest.fixture
    def made(self, handout, monkeypatch, limits):
        """The batch, of levels of which the base is 4 % off in twice its step, and exact N."""

        def levels(device, chosen, start):
            assert (chosen, start) == ("a model", FIRST)
            base, check = Known(device, off=(0.0, 0.01)), Known(device)
            return SimpleNamespace(device=device, base=base, check=check, levels=(base, check))

        monkeypatch.setattr(population, "choose_model", levels)
        choices = [Choice(self.rows.f0 == 1, "base", 2.0), Choice(self.rows.f0 == 2, "check", 3.0)]
        batch = Batch(handout, VALUES, "a model", choices, FIRST)
        thickness, N, duration, C = (column[:, np.newaxis] for column in VALUES.values())
        exact = thickness * C * self.rows.C * self.rows.f0 / duration / N
        return batch, np.where(thickness == 9.0, np.nan, exact)

    @pytest.mark.parametrize("chosen", [False, True])
    def test_each_row_has_its_level(self, made, chosen):
        made, exact = made
        off = np.where(chosen & (self.rows.f0 == 1), 1.04, 1.0)
        N, nominal, ragged = made.thresholds(self.rows, SETTINGS, 1e-3, chosen)
        np.testing.assert_allclose(N / off, 1.0005 * exact, rtol=6e-4)
        np.testing.assert_allclose(nominal / off, 2 * self.rows.C * self.rows.f0, rtol=1.1e-4)
        assert not ragged.any()

    def test_a_requirement_is_met_surely_in_both_steps_and_possibly_in_one(self, made):
        made, exact = made
        at, exists = 8.0 / exact, np.isfinite(exact)
        sure, possible = at >= STAYS, at >= STAYS * REPEATED_STEP
        assert (sure != possible).any() and (possible != (at >= 1)).any() and (at < 1).any()
        musts = {True: (sure, possible), False: 2 * (at < 1,), "any": 2 * (exists,)}
        for must, met in (musts | {"arrives": 2 * (at >= 1,)}).items():
            shock = Shock(name="drop", N=8.0, f0=1.0, shocks=make_shocks(), snaps=must)
            np.testing.assert_array_equal(made.meets(shock, self.rows, SETTINGS), met)

"""A device read off its shots."""

import math

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm
from small_results import drawn
from small_studies import cases_of

import snapmap
from snapmap import Study
from snapmap.applications.calibration import dataset, figure
from snapmap.applications.calibration.dataset import Profile, Surface, fit, reach, summary
from snapmap.applications.calibration.shots import read_shots, shots_from
from snapmap.pulse.shocks import HANDOUT_SHOCK

CHEAP = {"model": "3 cosines", "horizon": 300.0}
SHOTS = {"N": [850.0, 900.0, 940.0, 960.0, 1000.0, 1100.0], "duration": [1000.0] * 6}
SHOTS["tripped"] = [0, 0, 0, 1, 1, 1]


def straight(slopes, size=33):
    """Thresholds whose logarithms are linear over the unknowns, from -0.3 to 0.3 about 1000 g."""
    axes = np.meshgrid(*[np.linspace(-0.3, 0.3, size)] * slopes.shape[1], indexing="ij")
    logs = np.log(1000.0) + np.stack(axes, axis=-1) @ slopes.T
    names = ("thickness", "rise")[: slopes.shape[1]]
    return Surface(dict.fromkeys(names, (-0.3, 0.3)), logs)


SUM = straight(np.array([[1.0], [1.0]]))


def made_up(draw, surface, truth, spread, size=30):
    """Shots at a device of known values."""
    duration = np.where(np.arange(size) % 2, 500.0, 1000.0)
    logs = surface.at((np.array(truth) + 0.3) / 0.6)[0][np.arange(size) % surface.logs.shape[-1]]
    N = 1000.0 * np.exp(draw.uniform(-0.25, 0.25, size))
    apart = spread * draw.standard_normal(size)
    table = {"N": N, "duration": duration, "tripped": np.log(N) - logs > apart}
    return shots_from(table, HANDOUT_SHOCK, None)


def test_the_reach_of_an_interval_holds_95_percent():
    """Of Cauchy's distribution, of which the quantiles are tangents, and of the normal one."""
    assert reach(1) == pytest.approx(math.tan(math.pi * 0.95 / 2))
    assert math.erf(reach(10**9) / math.sqrt(2)) == pytest.approx(0.95)


@pytest.mark.parametrize("middle", [0.4, 0.02, 0.98, 0.13, 0.87, 0.5 - 1 / 64])
def test_an_interval_ends_where_a_parabola_has_fallen_far_enough(middle):
    """Or at an end of the range; also between the last points of the grid."""
    width, freedom = 0.05, 8
    half = width * reach(freedom)
    profile = profile_of(lambda u: -np.sum(((u - [middle, 0.5]) / width) ** 2, axis=1) / 2)
    assert profile.best == pytest.approx([middle, 0.5], abs=1e-3)
    low, high = profile.interval(0, freedom)
    assert low == pytest.approx(max(0.0, middle - half), abs=5e-4)
    assert high == pytest.approx(min(1.0, middle + half), abs=5e-4)


def test_an_interval_follows_a_ridge_that_all_points_of_the_grid_miss():
    """The second unknown is known well, the first not at all."""
    profile = profile_of(lambda u: -(((u[:, 1] - 0.5 - 1 / 64) / 0.002) ** 2) / 2)
    assert profile.interval(0, 8) == (0.0, 1.0)
    assert profile.nodes.max() < profile.most - 20


def profile_of(log):
    """The profile of a likelihood over two unknowns, with 33 points along each."""
    return Profile(log, log(np.array([*np.ndindex(33, 33)]) / 32).reshape(33, 33))


def test_intervals_cover_the_truth_of_made_up_campaigns():
    """Of ten that cover in 95 of 100 at least eight do, but for one in a hundred sets of them."""
    draw, covered = np.random.default_rng(1), 0
    for truth in np.linspace(-0.1, 0.1, 10):
        fitted = fit(made_up(draw, SUM, [truth], 0.03), SUM)
        covered += fitted.low.item() <= truth <= fitted.high.item()
        assert fitted.low < fitted.estimate < fitted.high < fitted.low + 0.2
    assert covered >= 8


def test_what_shots_do_not_tell_apart_keeps_its_ranges():
    """Thresholds depend on the sum alone: the difference of both is known from the ranges."""
    draw, surface = np.random.default_rng(2), straight(np.ones((2, 2)), size=17)
    fitted = fit(made_up(draw, surface, [0.0, 0.0], 0.03), surface)
    assert (fitted.low == -0.3).all() and (fitted.high == 0.3).all()
    assert fitted.correlation.values[0, 1] < -0.9
    assert "(-0.3 to 0.3)" in summary(fitted)


def test_residuals_are_those_of_the_fitted_probability():
    fitted = fit(made_up(np.random.default_rng(3), SUM, [0.0], 0.05), SUM)
    p = np.where(fitted.tripped, fitted.probability, 1 - fitted.probability)
    np.testing.assert_allclose(fitted.residual**2, -2 * np.log(p), rtol=1e-4, atol=1e-4)
    assert (np.sign(fitted.residual) == np.where(fitted.tripped, 1, -1))[p < 0.99].all()
    assert 0.01 < fitted.spread[0] < 0.2


def test_the_thickness_is_read_off_shots_of_the_solver_itself(handout):
    fitted = snapmap.calibrate(Study(handout, **CHEAP), SHOTS, {"thickness": (1.8, 2.2)}, C=25.0)
    thickness = [1.9, 2.0]
    N = snapmap.threshold(
        Study(handout, **CHEAP), [1000.0], [25.0], axes={"thickness": thickness}
    ).N_first
    expected = np.interp(950.0, N.values.ravel(), thickness)
    assert fitted.estimate.item() == pytest.approx(expected, abs=0.005)
    assert fitted.low < fitted.estimate < fitted.high and fitted.model_error < 2e-3
    assert fitted.threshold.values == pytest.approx(950.0, abs=5.0)


def test_a_likelihood_is_a_product_of_normal_probabilities_and_its_information_fishers():
    """Of lognormal thresholds, whose errors add to the spread; slopes of 1."""
    shots, error, at = shots_from(SHOTS, HANDOUT_SHOCK, None), 0.03, np.log(950.0)
    z = (np.log(shots.N) - at) / np.sqrt(dataset.SPREADS[:, None] ** 2 + error**2)
    likelihood = dataset.Likelihood(shots, np.array([error]))
    expected = norm.logcdf(np.where(shots.tripped, z, -z)).sum(axis=1)
    np.testing.assert_allclose(likelihood.of(np.array([[at]]))[0], expected)
    place, surface = np.array([(at - np.log(1000.0) + 0.3) / 0.6]), straight(np.ones((1, 1)))
    covariance, slopes = dataset.information_at(place, surface, likelihood, 0.05)
    z = (np.log(shots.N) - at) / 0.05
    fisher = (norm.pdf(z) ** 2 / norm.cdf(z) / norm.sf(z)).sum() * (0.6 / 0.05) ** 2
    assert slopes == pytest.approx(0.6) and covariance == pytest.approx(1 / (fisher + 12.0))


@pytest.mark.usefixtures("paper")
def test_shots_stand_on_the_side_of_their_outcome_beside_the_fit():
    columns = {"f0": [1e3, 1e3, 2e3], "N": [900.0, 1100.0, 1000.0], "tripped": [0, 1, 0]}
    columns |= {"threshold": [1e3, 1e3, 1.2e3], "threshold_low": [950.0, 950.0, 1100.0]}
    columns |= {"threshold_high": [1050.0, 1050.0, 1300.0]}
    columns |= {"direction": ["+z"] * 3, "shape": ["half sine"] * 3}
    variables = {key: ("shot", values) for key, values in columns.items()}
    variables["spread"] = "bound", [0.05]
    (panel,) = figure.panels(xr.Dataset(variables, {"bound": ["estimate"]}))
    ax = drawn(figure.draw_shots, panel)
    assert ax.get_xlim() == pytest.approx((1e3 / 1.2, 2e3 * 1.2))
    assert ax.get_ylim() == pytest.approx((900.0 / 1.2, 1100.0 * 1.2))
    fit, stayed, tripped = ax.lines
    assert fit.get_xydata().tolist() == [[1e3, 1e3], [2e3, 1.2e3]]
    assert stayed.get_ydata().tolist() == [900, 1000] and tripped.get_ydata().tolist() == [1100]
    assert [shots.get_markerfacecolor() for shots in (stayed, tripped)] == ["white", "black"]


@pytest.mark.parametrize(("table", "remedy"), cases_of(__file__))
def test_a_remedy_for_a_table_is_itself_right(tmp_path, table, remedy):
    (tmp_path / "shots.csv").write_text(table, encoding="utf-8")
    with pytest.raises(ValueError, match=remedy):
        read_shots(tmp_path / "shots.csv")

"""A device read off its shots."""

import math
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
import yaml
from scipy.stats import norm, truncnorm
from small_results import drawn
from small_studies import TINY, cases_of
from varied import alone, varied

import snapmap
from snapmap import Study
from snapmap.applications.calibration import dataset, figure
from snapmap.applications.calibration.dataset import Profile, Surface, fit, reach, summary
from snapmap.applications.calibration.shots import check_ranges, read_shots, shots_from
from snapmap.applications.whole import load_config
from snapmap.pulse.shocks import HANDOUT_SHOCK

CHEAP = {"model": "3 cosines", "horizon": 300.0}
SHOTS = {"N": [850.0, 900.0, 940.0, 960.0, 1000.0, 1100.0], "duration": [1000.0] * 6}
SHOTS["tripped"] = [0, 0, 0, 1, 1, 1]
CASES = cases_of(__file__)


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


def test_residuals_and_bands_are_those_of_the_fitted_probability():
    """With the error of the interpolation; the band is as wide as the estimate is unsure."""
    surface = straight(np.array([[1.0], [1.0]]))
    surface.error = np.array([0.02, 0.02])
    shots = made_up(np.random.default_rng(3), surface, [0.0], 0.05)
    fitted = fit(shots, surface)
    p = np.where(fitted.tripped, fitted.probability, 1 - fitted.probability)
    np.testing.assert_allclose(fitted.residual**2, -2 * np.log(p), rtol=1e-4, atol=1e-4)
    assert (np.sign(fitted.residual) == np.where(fitted.tripped, 1, -1))[p < 0.99].all()
    assert 0.01 < fitted.spread[0] < 0.2 and fitted.model_error == 0.02
    z = np.log(fitted.N / fitted.threshold) / np.hypot(fitted.spread.item(0), 0.02)
    np.testing.assert_allclose(fitted.probability, norm.cdf(z), rtol=1e-3)
    likelihood, ends = dataset.Likelihood(shots, surface.error), fitted[["estimate", "low", "high"]]
    places = (ends.to_array().values + 0.3) / 0.6
    most, *falls = likelihood.integrated(surface.at(places))
    assert falls == pytest.approx([most - reach(28) ** 2 / 2] * 2, abs=0.01)
    at = places[0], surface, likelihood, fitted.spread.item(0)
    half = reach(28) * 0.6 * math.sqrt(dataset.information_at(*at)[0].item())
    for side, key in ((-1, "threshold_low"), (1, "threshold_high")):
        np.testing.assert_allclose(np.log(fitted[key] / fitted.threshold), side * half, rtol=1e-3)


@pytest.mark.parametrize(("low", "high", "ends"), CASES["places"])
def test_before_the_shots_a_spread_is_lognormal_about_4_percent(low, high, ends):
    """Here it is exp(place), of places within the intervals and half as far again."""
    logs = np.log(0.04) + 0.9 * np.linspace(-4.0, 2.0, 33)[:, np.newaxis]
    for width, range_ in ((1e4, (-9.0, 9.0)), (0.15, ends)):
        of = lambda logs: -(((np.log(dataset.SPREADS) - logs) / width) ** 2)  # noqa: B023, E731
        places = Surface({"rise": (0.0, 1.0)}, logs), np.array([low]), np.array([high])
        found = dataset._spreads(SimpleNamespace(of=of), *places)
        exact = 0.04 * np.exp(0.9 * truncnorm.ppf([0.5, 0.025, 0.975], *range_))
        assert found[:1] == pytest.approx(exact[:1], rel=0.01)
        assert width < 1 or found == pytest.approx(exact, rel=0.02)


def test_the_thickness_is_read_off_shots_of_the_solver_itself(handout):
    fitted = snapmap.calibrate(Study(handout, **CHEAP), SHOTS, {"thickness": (1.8, 2.2)}, C=25.0)
    thickness, study = [1.9, 2.0], Study(handout, **CHEAP)
    N = snapmap.threshold(study, [1000.0], [25.0], axes={"thickness": thickness}).N_first
    expected = np.interp(950.0, N.values.ravel(), thickness)
    assert fitted.estimate.item() == pytest.approx(expected, abs=0.005)
    assert fitted.low < fitted.estimate < fitted.high and 2e-4 < fitted.model_error < 2e-3
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
    variables = {key: ("shot", values) for key, values in CASES["drawn"].items()}
    fitted = {"estimate": 2.0, "low": 1.9, "high": 2.1}
    variables |= {key: ("unknown", [value]) for key, value in fitted.items()}
    variables["spread"] = "bound", [0.05]
    data = xr.Dataset(variables, {"bound": ["estimate"], "unknown": ["thickness"]})
    data.estimate.attrs["comment"] = "thickness: um"
    assert figure.calibration_text(data) == "thickness 2 µm (1.9 to 2.1), spread 5 %"
    panel, back = figure.panels(data.assign(direction=("shot", ["+z", "+z", "-z"])))
    assert (panel.shot.size, back.attrs["panel"]) == (2, "half sine along −z")
    wide = np.exp(1.959964 * 0.05)  # 95 % of shots
    ax = drawn(figure.draw_shots, panel)
    scatters, sure = ax.collections
    for band, by in ((sure, 1.0), (scatters, wide)):
        ends = [[1e3 / 1.2, 950 / by], [1e3 * 1.2, 1050 * by]]
        points = band.get_datalim(ax.transData).get_points()
        np.testing.assert_allclose(points, ends, rtol=1e-4)
    (panel,) = figure.panels(data)
    ax = drawn(figure.draw_shots, panel)
    assert ax.get_xlim() == pytest.approx((1e3 / 1.2, 2e3 * 1.2))
    assert ax.get_ylim() == pytest.approx((900.0 / 1.2, 1100.0 * 1.2))
    fit, stayed, tripped = ax.lines
    assert fit.get_xydata().tolist() == [[1e3, 1e3], [2e3, 1.2e3]]
    assert stayed.get_ydata().tolist() == [900, 1000] and tripped.get_ydata().tolist() == [1100]
    assert [shots.get_markerfacecolor() for shots in (stayed, tripped)] == ["white", "black"]
    assert stayed.get_xdata() == pytest.approx([1e3 / 1.01, 2e3 / 1.01])
    assert tripped.get_xdata() == pytest.approx([1010.0])


@pytest.mark.parametrize(("table", "remedy"), CASES["tables"])
def test_a_remedy_for_a_table_is_itself_right(tmp_path, table, remedy):
    (tmp_path / "shots.csv").write_text(table, encoding="utf-8")
    with pytest.raises(ValueError, match=remedy):
        read_shots(tmp_path / "shots.csv")


@pytest.mark.parametrize(("columns", "line"), CASES["refused"])
def test_shots_that_say_nothing_are_refused(handout, columns, line):
    right = {"N": [900.0, 950.0, 1000.0], "f0": [1e3] * 3, "tripped": [0, 1, 1]}
    with pytest.raises(ValueError, match=rf"^{line}"):
        shots_from(right | columns, HANDOUT_SHOCK, handout)


@pytest.mark.parametrize(("unknowns", "C", "line"), CASES["ranges"])
def test_ranges_ascend_and_keep_the_second_shape(handout, unknowns, C, line):
    with nullcontext() if line is None else pytest.raises(ValueError, match=rf"^{line}$"):
        check_ranges(unknowns, C, handout)


def test_shots_of_a_pulse_its_direction_and_its_f0_are_a_group(handout, tmp_path, monkeypatch):
    """What a row leaves out is as of the study; a record has its own N and f0."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bump.csv").write_text("time (ms),a (g)\n0,0\n1,500\n2,0\n", encoding="utf-8")
    shots = shots_from(CASES["right"], HANDOUT_SHOCK, handout)
    levels = [900, 1000, 1100, 1200, 0.5, 700, 600, 500 * 9.80665 / 9.81]
    assert shots.N.tolist() == pytest.approx(levels) and [*shots.group] == [0, 1, 2, 2, 3, 4, 5, 6]
    assert shots.tripped.tolist() == [False] * 3 + [True] * 3 + [False] * 2
    assert shots.f0.tolist() == [1e3] * 6 + [500.0] * 2
    back, half, bump = map(str, shots.groups[3:6])
    assert back == "versed sine along -z, f0 = 1000 Hz" and half.startswith("half sine along +z")
    assert bump == "bump.csv along +z, f0 = 500 Hz"
    area = [group.pulse.area for group in shots.groups]
    assert area == pytest.approx([0.5, 0.5, 0.5, -0.5, 2 / np.pi, 0.5, 0.5])
    times = xr.DataArray([1.0] * 6, attrs={"units": "ms"})
    for duration in (times, [times[0]] * 6, ["1 ms"] * 6):
        assert shots_from(SHOTS | {"duration": duration}, HANDOUT_SHOCK, handout).f0[0] == 1e3
    with pytest.raises(ValueError, match=r"^shots, row 7: file: a record shakes the frame"):
        shots_from(CASES["right"], HANDOUT_SHOCK, alone(handout, 1.0))


def test_shots_that_are_twice_as_far_as_any_threshold_are_refused(study, monkeypatch):
    """Of thresholds from 100 to 200; one shot that is nearer suffices."""
    logs = np.log([[100.0], [130.0], [200.0]])
    monkeypatch.setattr(dataset, "log_thresholds", lambda *_: logs)
    for low, high, is_far in ((401, 500, True), (399, 500, False), (10, 49, True), (10, 51, False)):
        table = {"N": [low, low, high], "f0": [1e3] * 3, "tripped": [0, 0, 1]}
        line = rf"^shots: N is {low} to {high}, but .* give 100 to 200; is N in multiples of g\?$"
        with pytest.raises(ValueError, match=line) if is_far else nullcontext():
            shots = shots_from(table, HANDOUT_SHOCK, None)
            dataset.refuse_far(study, shots, {"rise": (9.0, 11.0)}, 25.0)


def test_thresholds_over_unknowns_are_those_of_each_device(handout):
    """Also over C, and of several groups of shots; none without a second shape or a threshold."""
    values = {"thickness": np.array([1.9, 2.1, 2.0]), "C": np.array([20.0, 40.0, 25.0])}
    table = SHOTS | {"shape": ["", "half sine"] * 3}
    groups, study = shots_from(table, HANDOUT_SHOCK, handout).groups, Study(handout, **CHEAP)
    logs = dataset.log_thresholds(study, groups, values, None)
    for row, thickness, C in zip(logs, *values.values(), strict=True):
        how = CHEAP | {"pulse": ["versed sine", "half sine"]}
        one = Study(varied(handout, thickness=thickness), **how)
        N = snapmap.threshold(one, [1000.0], [C], tolerance=1e-4).N_first
        assert row == pytest.approx(np.log(N.values.ravel()), abs=1e-3)
    for key, value, line in (
        ("thickness", 4.4, "unknowns: no second stable shape at thickness = 4.4 um; write a narr"),
        ("C", 1e9, "shots: the model has no threshold for versed sine along .z, f0 = 1000 Hz at"),
    ):
        with pytest.raises(ValueError, match=f"^{line}"):
            other = values | {key: np.array([values[key][0], value, value])}
            dataset.log_thresholds(study, groups, other, None)


def test_a_surface_is_straight_between_its_points_over_up_to_four_unknowns(study, monkeypatch):
    """Its error is that of single thresholds where the logarithms are straight, too."""
    plane = lambda *given: np.sum([*given[2].values()], axis=0)[:, np.newaxis]  # noqa: E731
    monkeypatch.setattr(dataset, "log_thresholds", plane)
    for count, size in ((1, 33), (2, 17), (3, 9), (4, 6)):
        unknowns = {str(i): (i, i + 2) for i in range(count)}
        surface = dataset.surface_of(study, [None], unknowns, 25.0)
        assert surface.logs.shape == (*[size] * count, 1)
        assert surface.error == pytest.approx(2e-4)
        places = np.full((1, count), 0.3)
        assert surface.at(places).item() == pytest.approx(surface.values(places).sum())


@pytest.mark.parametrize(("written", "of_sweep", "C"), CASES["dampings"])
def test_C_is_written_or_of_the_sweep_or_unknown(tmp_path, monkeypatch, written, of_sweep, C):
    monkeypatch.chdir(tmp_path)
    shots = "N,f0,tripped,file\n900,1e3,no,\n950,1e3,yes,\n999,1e3,yes,\n"
    (tmp_path / "shots.csv").write_text(shots)
    document = yaml.safe_load(TINY) | {"calibration": {"shots": "shots.csv"} | written}
    document["sweep"]["C"] = of_sweep
    asked = load_config(document).requests["calibration"]
    assert asked.C == C and [*asked.files] == ["shots.csv"] and asked.shots.N.tolist()[0] == 900
    assert asked.unknowns in ({"thickness": [1.7, 2.1]}, {"C": [10.0, 40.0]})

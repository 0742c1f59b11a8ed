"""Devices as made: samples, thresholds, probability, sensitivity and yield."""

import itertools
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
import yaml
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex, to_rgb
from scipy import stats
from small_results import artists, drawn
from small_studies import TINY, cases_of, changed, faults
from varied import varied

import snapmap
from snapmap import Study
from snapmap.applications import tolerances
from snapmap.applications.requirements.figure import WRONG
from snapmap.applications.tolerances import dataset, figure
from snapmap.applications.whole import load_config
from snapmap.device.device import batch
from snapmap.device.samples import Plan, Scatter, Tolerances
from snapmap.figures import style
from snapmap.figures.states import SNAPS
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model, follow_twice
from snapmap.study.shock import Shock

CASES = cases_of(__file__)
CHEAP = {"model": "3 cosines", "horizon": 300.0}
STRENGTH = 330.0


def ishigami(u):
    x1, x2, x3 = np.moveaxis(np.pi * (2 * u - 1), -1, 0)
    return (np.sin(x1) + 7 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1))[..., np.newaxis]


def test_indices_are_those_of_ishigamis_function():
    """Ishigami and Homma (1990): variances of the parts, with a = 7 and b = 0.1."""
    both, lone, rest = 0.5 * (1 + np.pi**4 / 50) ** 2, 49 / 8, np.pi**8 * (1 / 18 - 1 / 50) / 100
    exact = np.array([[both, lone, 0], [both + rest, lone, rest]]) / (both + lone + rest)
    scatters = dict.fromkeys(("N", "C", "duration"), Scatter("normal", 0.01, True))
    points = Plan(None, scatters).points(4096, seed=1)
    (first, second), mixed = map(ishigami, points), ishigami(dataset.crossed(points))
    estimates = dataset.indices(first, second, mixed, seed=5)[..., 0]
    np.testing.assert_allclose(estimates[:, 0], exact, atol=0.01)
    assert (estimates[:, 1] <= exact).all() and (exact <= estimates[:, 2]).all()
    first[[3, 70, 500]] = np.nan
    again = dataset.indices(first, second, mixed, seed=5)[..., 0]
    np.testing.assert_allclose(again[:, 0], exact, atol=0.03)


def test_indices_of_few_weighted_samples_are_those_of_their_sums():
    """Variance of both draws together; half the mean square change; Saltelli (2010)."""
    random = np.random.default_rng(3)
    first, second, mixed = 5 + random.normal(size=(3, 4)) + [[0.0], [0.5], [0.2]]
    weights = np.array([[0.25, 0.5], [0.25, 0.0], [0.25, 0.125], [0.25, 0.375]])
    found = dataset._both_orders(first, second, mixed[np.newaxis], weights)[:, 0]
    for weight, orders in zip(weights.T, found.T, strict=True):
        middle = weight @ (first + second) / 2
        variance = weight @ ((first - middle) ** 2 + (second - middle) ** 2) / 2
        alone, total = (second - middle) * (mixed - first), (mixed - first) ** 2 / 2
        assert orders == pytest.approx([weight @ alone / variance, weight @ total / variance])


def test_statistics_count_what_never_snaps():
    N_first = np.array([[3.0], [1.0], [np.nan], [2.0]])
    assert dataset.count_below(N_first, np.array([0.5, 1, 2.5, 9])).tolist() == [[0, 1, 2, 3]]
    assert dataset.quantiles(N_first, [0.25, 0.5, 0.75])[:, 0].tolist() == [1, 2, 3]
    assert np.isnan(dataset.quantiles(N_first, [0.9])).all()
    assert [*dataset.moments(N_first)] == [2.0, 1.0]
    np.testing.assert_array_equal(dataset.moments(N_first[:1]), [[3.0], [np.nan]])


def test_bounds_of_a_quantile_are_order_statistics():
    """At 95 % each: of so many samples at least `low` lie below the median, and so on."""
    shares, N_first = [0.001, 0.05, 0.5, 0.95, 0.999], np.arange(1.0, 2996.0)[:, np.newaxis]
    bounds = lambda size: dataset.quantile_bounds(N_first[:size], shares)[..., 0]  # noqa: E731
    low, high = bounds(2995)
    for fewest, ends in ((2995, [0, -1]), (59, [1, 3])):
        assert bounds(fewest)[[0, 1], ends].tolist() == [1, fewest]
        assert np.isnan(bounds(fewest - 1)[[0, 1], ends]).all()
    assert stats.binom.sf(low[2] - 1, 2995, 0.5) >= 0.95 > stats.binom.sf(low[2], 2995, 0.5)
    assert stats.binom.cdf(high[2] - 1, 2995, 0.5) >= 0.95 > stats.binom.cdf(high[2] - 2, 2995, 0.5)
    assert (low[1:-1] < dataset.quantiles(N_first, shares)[1:-1, 0]).all()


def test_thresholds_are_those_of_the_devices_one_by_one(handout):
    scatters = {"thickness": "5 %", "youngs_modulus": "5 %", "duration": "3 %", "N": "2 %"}
    f0, C = [400.0, 1500.0, 4000.0], [25.0, 200.0]
    study = Study(handout, threads=2, **CHEAP)
    made = snapmap.tolerance(study, scatters, f0, C, samples=100, seed=2)
    assert made.N_first.notnull().all() and (made.bistable == 1).all()
    for i in (0, 17, 80, 99):
        sample = made.isel(sample=i)
        values = {key: sample[key].item() for key in ("thickness", "youngs_modulus")}
        stretched = np.array(f0) / sample.duration_factor.item()
        alone = snapmap.threshold(Study(varied(handout, **values), **CHEAP), stretched, C)
        off = abs(sample.N_first.values * sample.N_factor.item() / alone.N_first.values - 1)
        # Clean rows may hide an island as narrow as their bars.
        known = np.fmax(1.2e-3, (alone.N_error / alone.N_first).values)
        assert (off < known)[alone.ragged.values == 0].all()
        assert (off < 0.01).all() and (alone.ragged == 0).mean() >= 0.5


def test_every_row_is_taken_by_a_level_that_keeps_the_tolerance(handout):
    f0, C = [300.0, 1000.0, 2000.0, 5000.0, 12000.0], [25.0]
    made = snapmap.tolerance(handout, {"thickness": "1 %"}, f0, C, samples=2)
    best = snapmap.threshold(Study(handout, "11 cosines"), f0, C)
    assert (best.ragged == 0).all()
    off = abs(made.N_nominal / best.N_first - 1)
    assert (off < 1e-3 + best.N_error / best.N_first).all()


def test_small_scatter_adds_up_as_the_linear_estimate_says(handout):
    """Standard deviations and indices from the slopes, as docs/limits.md lists them."""
    scatters = dict.fromkeys(("thickness", "youngs_modulus", "rise"), "1 %")
    shock = [1500], [0.025]
    how = {"samples": 1024, "threshold_tolerance": 1e-4}
    made = snapmap.tolerance(Study(handout, threads=2, **CHEAP), scatters, *shock, **how)
    linear, percent = [], np.array([0.99, 1.01])
    for key in scatters:
        axes = {key: percent * getattr(handout.beam, key)}
        asked = Study(handout, **CHEAP)
        N = snapmap.threshold(asked, *shock, tolerance=1e-6, axes=axes).N_first.squeeze()
        linear.append(0.01 * (np.diff(np.log(N)) / np.diff(np.log(percent))).item())
    spread = np.linalg.norm(linear)
    assert (made.N_std / made.N_nominal).item() == pytest.approx(spread, rel=0.02)
    share = np.square(linear) / spread**2
    for order in ("first", "total"):
        index = made.sensitivity.sel(order=order).squeeze()
        np.testing.assert_allclose(index, share, atol=0.02)
    low, high = made.sensitivity_bound.sel(order="first").squeeze().transpose("bound", "value")
    assert (low <= share).all() and (share <= high).all()


@pytest.fixture(scope="module")
def scattered(handout):
    """Devices of which some have no second shape, and a shock that about half of them withstand."""
    study = Study(varied(handout, rise=5.0), **CHEAP)
    return snapmap.tolerance(study, **CASES["scattered"]).isel(C=0)


def test_samples_without_a_second_shape_count_and_never_snap(scattered):
    lost = scattered.thickness > 5 * np.sqrt(3) / 4
    np.testing.assert_array_equal(scattered.bistable == 0, lost)
    assert 0.1 < lost.mean() < 0.5
    snaps = scattered.N_first.notnull()
    assert not (snaps & lost).any() and (snaps | lost).all()
    assert scattered.probability.max() == pytest.approx(1 - lost.mean().item())


@pytest.mark.usefixtures("paper")
def test_devices_with_one_threshold_have_a_probability_at_it_alone(handout):
    scattered = {"thickness": 1e-15}, [1500.0], [25.0]
    made = snapmap.tolerance(Study(handout, **CHEAP), *scattered, samples=4)
    assert made.N.size == 1 and made.N.item() == made.N_first[0].item()
    ax = drawn(figure.draw_probability, made.isel(C=0))
    assert ax.get_xlim()[0] < made.N.item() < ax.get_xlim()[1]


def test_shares_that_meet_requirements_are_those_of_the_thresholds(handout):
    how = {"samples": 100, "requirements": CASES["required"]}
    brittle = replace(handout, strength=320.0)
    made = snapmap.tolerance(Study(brittle, **CHEAP), {"thickness": "5 %"}, [1500.0], [25.0], **how)
    made = made.squeeze("C")
    first, rests = made.N_first_required.values
    trips, quiet = first <= 1000 * 1.001, ~(rests <= 850)  # each the upper end of its step
    whole = made.stress_max.values <= 320.0
    shares = (trips & whole[0]).mean(), (quiet & whole[1]).mean()
    np.testing.assert_allclose(made.share_meeting, shares, atol=0.016)
    good = (trips & quiet & whole.all(axis=0)).mean()
    assert made["yield"].item() == pytest.approx(good, abs=0.016) and 0 < good < min(shares)
    low, high = made.yield_bound.values
    assert low < made["yield"].item() < high
    np.testing.assert_allclose(made.share_breaking, (~whole).mean(axis=1))
    assert 0 < made.share_breaking.values[0] < 1
    alone = varied(handout, thickness=made.thickness[0].item())
    run = snapmap.simulate(Study(alone, pulse="half sine", **CHEAP), 1000, 2000, 25)
    assert run.stress_max == pytest.approx(made.stress_max.values[0, 0], rel=0.05)
    kept = snapmap.threshold(Study(handout, pulse="half sine", **CHEAP), [2000.0], [25.0])
    at_mean = np.interp(made.thickness.mean(), *np.sort([made.thickness, first]))
    assert at_mean == pytest.approx(kept.N_first.item(), rel=5e-3)


def test_a_device_that_must_trip_and_comes_back_is_no_yield(handout):
    """At four times the threshold all arrive, and as many stay as by their runs in two steps."""
    light = varied(handout, thickness=3.0, rise=7.3, damping=2e-3)
    study, at = Study(light, "3 cosines", pulse="half sine", horizon=4000.0), ([2000.0], [25.0])
    made = snapmap.tolerance(study, {"thickness": {"uniform": "1 %"}}, *at, **CASES["arriving"])
    devices = batch([varied(light, thickness=value) for value in made.thickness.values])
    cells = to_cells(devices, np.arange(32), 5600.0, *at, 4000.0, 0, study.shocks.pulses)
    runs = follow_twice(build_model(devices, study.model), cells, study.run.but(until="end"))
    stay = np.mean([run.well == 2 for run in runs])
    assert 0.1 < stay < 0.95
    np.testing.assert_allclose(made.share_meeting.squeeze("C"), [stay, 1.0, 0.0, 1.0])
    assert made.must_snap.values.tolist() == [1, 3, 0, 2] and made["yield"].item() == 0.0


def test_a_requirement_is_met_under_all_its_shocks_at_all_temperatures(handout, study):
    device = replace(handout, modulus_slope=-1e-3, strength=STRENGTH)
    scatters = {"thickness": Scatter("normal", 0.05, False)}
    made = Tolerances(scatters, samples=32, index_samples=2)
    both, degrees = make_shocks(["half sine", "versed sine"]), np.array([-40.0, 120.0])
    common, axes = {"N": 1000.0, "f0": 1500.0, "shocks": both}, {"C": [25.0], "f0": [1500.0]}
    musts = {"trips": "arrives", "rests": False, "survives": "any"}
    needs = [Shock(name=name, snaps=must, **common) for name, must in musts.items()]
    needs[1] = replace(needs[1], survives=0.0)  # it may break
    tempered = axes | {"temperature": degrees}
    met = dataset.tolerances_of(replace(study, device=device), tempered, made, needs)
    corners = []
    for T, shocks in itertools.product(degrees, both.each()):
        single = [replace(required, shocks=shocks) for required in needs[:2]]
        corner = dataset.tolerances_of(replace(study, device=device.at(T)), axes, made, single)
        corners.append(corner.N_first_required.squeeze("C").values)
    most, least = np.max(corners, axis=0)[0], np.min(corners, axis=0)[1]
    trips, rests, _ = met.N_first_required.squeeze("C").values
    np.testing.assert_allclose([trips, rests], [most, least], rtol=2e-3)  # steps of the search
    stress = met.stress_max.squeeze("C").values
    np.testing.assert_array_equal(stress[0], stress[1])
    whole = stress <= STRENGTH
    meets = np.stack([whole[0] & (most <= 1000), least > 1000, whole[2]])
    np.testing.assert_allclose(met.share_meeting.squeeze("C"), meets.mean(axis=1), atol=1 / 32)
    np.testing.assert_allclose(met.share_breaking.squeeze("C"), 1 - whole.mean(axis=1))
    assert met["yield"].temperatures == "-40 to 120 degC"
    assert 0 < meets.mean() < 1 and met.must_snap.values.tolist() == [3, 0, 2]


@pytest.mark.usefixtures("paper")
def test_probabilities_and_indices_are_drawn_as_they_are(scattered):
    ax = drawn(figure.draw_probability, scattered)
    (field,) = ax.collections
    np.testing.assert_array_equal(field.get_array(), scattered.probability.transpose("N", "f0"))
    ends = [to_hex(colour) for colour in field.get_cmap()([0.0, 1.0])]
    assert ends == [state.colour for state in SNAPS[:2]]  # no grey, which is what is not known
    *lines, nominal, no_fire, all_fire = (line.get_ydata() for line in ax.lines)
    expected = scattered.N_quantile.sel(quantile=list(figure.LINES))
    np.testing.assert_array_equal(lines, expected)
    np.testing.assert_array_equal(nominal, scattered.N_nominal)
    np.testing.assert_array_equal(no_fire, scattered.N_no_fire)
    assert np.isnan(all_fire).all()
    words = ax.get_title(loc="left")
    assert "temperature 20 °C" in words and words.endswith("all-fire takes 2995 devices")
    # Few values of N do not move the shares at which the levels lie.
    one = scattered.isel(f0=[1])
    curve, *_ = drawn(figure.draw_probability, one.isel(N=[0, -1])).lines
    steps = np.searchsorted(curve.get_xdata(), one.N, side="right") - 1
    np.testing.assert_array_equal(curve.get_ydata()[steps], one.probability.squeeze())
    # Bounds of shares end at 1.
    bounds = scattered.sensitivity_bound + xr.DataArray([0.0, 0.5], dims="bound")
    more = {"sensitivity_bound": bounds, "sensitivity": 1.2 * scattered.sensitivity}
    ax = drawn(figure.draw_sensitivity, scattered.assign(more))
    shown = [line.get_ydata().tolist() for line in ax.lines if len(line.get_ydata()) == 3]
    expected = np.minimum(more["sensitivity"], 1).values.reshape(-1, 3).tolist()
    assert sorted(shown) == sorted(expected)
    tops = [bar.get_segments()[0][1, 1] for bar in artists(ax, LineCollection)]
    ends = bounds.sel(order="total").isel(bound=1, f0=0)
    np.testing.assert_allclose(tops, np.minimum(ends, 1))
    assert ends.max() > 1
    few, f0 = "few devices snap", [800.0, 1500.0, 3000.0]
    cases = (f0[::2], [f0[1:2]], []), (f0, [], []), ([], [], [f"nothing to show: {few}"])
    for known, crossed, said in cases:
        part = scattered.sensitivity.where(scattered.f0.isin(known))
        ax = drawn(figure.draw_sensitivity, scattered.assign(sensitivity=part))
        crosses = [line for line in ax.lines if line.get_label() == f"not known: {few}"]
        assert [cross.get_xdata().tolist() for cross in crosses] == crossed
        assert [text.get_text() for text in ax.texts] == said


@pytest.mark.usefixtures("paper")
def test_yields_and_requirements_are_drawn_as_they_are(scattered):
    ax = drawn(figure.draw_yield, scattered.expand_dims(C=[25.0], axis=-1))
    shares = [scattered.share_meeting.item(), scattered["yield"].item()]
    assert ax.lines[0].get_xydata().tolist() == [[share, i] for i, share in enumerate(shares)]
    assert [0.5, 0.5] in [[*line.get_ydata()] for line in ax.lines]  # above all together
    low = min(scattered.share_meeting_bound.min(), scattered.yield_bound.min()).item()
    assert low - 0.1 < ax.get_xlim()[0] < low and ax.get_xlim()[1] > 1
    ax = drawn(figure.draw_requirement, scattered.isel(requirement=0))
    known = scattered.N_first_required.count().item()
    assert sum(patch.get_height() for patch in ax.patches[1:]) == known < 128
    assert ax.patches[0].get_x() == 400.0
    assert ax.patches[0].get_facecolor()[:3] == pytest.approx(to_rgb(WRONG["color"]))
    ends = scattered.N_first_required.min().item(), scattered.N_first_required.max().item()
    room = 0.05 * (ends[1] - ends[0])
    assert ax.get_xlim() == pytest.approx((ends[0] - room, ends[1] + room))
    assert ax.get_title(loc="left").endswith("met by 30.9 %")


@pytest.mark.usefixtures("paper")
def test_words_on_a_batch_and_shares_of_each_damping_and_of_unbroken_beams(scattered):
    lost, spread = int((scattered.bistable == 0).sum()), scattered.N_std / scattered.N_mean
    spread = f"{100 * spread.min():.1f} to {100 * spread.max():.1f}"
    words = CASES["words"].format(lost=lost, spread=spread)
    words_of = [figure.words_of(key) for key in ("thickness+depth", "N", "duration")]
    told = [dataset.summary(scattered), figure.batch_text(scattered), figure.fire_words(scattered)]
    assert [*told, *words_of] == words.splitlines()
    breaking = scattered.share_meeting_bound * 0 + xr.DataArray([0.2, 0.35], dims="bound")
    more = {"share_breaking": scattered.share_meeting * 0 + 0.25, "share_breaking_bound": breaking}
    _, (name, share, ends), _ = figure.each_share(scattered.assign(more))
    assert (name, share.item(), ends.values.tolist()) == ("drop, unbroken", 0.75, [0.65, 0.8])
    two = scattered.expand_dims(C=[25.0, 40.0], axis=-1).assign(must_snap=scattered.must_snap)
    ax = drawn(figure.draw_yield, two)
    left, right = (line.get_ydata() for line in ax.lines[:2])
    assert left == pytest.approx([-0.175, 0.825]) and right == pytest.approx([0.175, 1.175])
    low, high = scattered.yield_bound.values
    bar = artists(ax, LineCollection)[0].get_segments()[1][:, 0]
    assert bar == pytest.approx([low, high]) and ax.get_ylim() == (1.5, -0.5)
    assert {text.get_text() for text in ax.texts} == {"30.9 % (22.3 to 40.3 %)"}
    assert ax.get_xlim() == pytest.approx((low - 0.05 * (1 - low), 1 + 0.05 * (1 - low)))


@pytest.mark.usefixtures("paper")
@pytest.mark.parametrize(("stem", "C", "needs", "count", "columns", "height"), CASES["panels"])
def test_panels_stand_side_by_side(scattered, monkeypatch, stem, C, needs, count, columns, height):
    pages = []
    for key in ("draw_sensitivity", "draw_probability", "draw_requirement", "draw_yield"):
        monkeypatch.setattr(figure, key, lambda *_: None)
    add = lambda stem, attributes, height: pages.append(style.double_column(height))  # noqa: E731
    monkeypatch.setattr(style, "saved", lambda *given: nullcontext(add(*given) or pages[0]))
    data = scattered.isel(requirement=[0] * needs).expand_dims(C=25.0 + np.arange(C), axis=-1)
    data["must_snap"] = "requirement", [1] * needs
    data = data.assign_coords(requirement=[*"abcdef"[:needs]])
    figure.draw_stem(f"figures/{stem}", data)
    axes = pages[0].subfigs[-1].axes
    assert (len(axes), axes[0].get_gridspec().ncols) == (count, columns)
    assert pages[0].get_figheight() == pytest.approx(height)


@pytest.mark.usefixtures("paper")
def test_shares_that_stay_are_drawn_from_where_all_above_stay(scattered):
    share = np.linspace(0.0, 1.0, scattered.N.size) * np.array([[1.0], [0.8], [0.4]])
    share[0, -1] = 0.9
    data = scattered.assign(latched=(("f0", "N"), share))
    half, most = drawn(figure.draw_probability, data).lines[-2:]
    N = scattered.N.values
    assert half.get_ydata() == pytest.approx([N[50], N[63], np.nan], nan_ok=True)
    assert np.isnan(most.get_ydata()).all()
    assert half.get_label() == "50 % latched at all $N$ above"
    ax = drawn(figure.draw_probability, data.isel(f0=[1]))
    assert [*ax.lines[-1].get_ydata()] == [*share[1]] and ax.get_xlim() == (N[0], N[-1])


def test_a_yield_names_what_it_leaves_out(monkeypatch):
    study = load_config(changed(yaml.safe_load(TINY), **CASES["leaving out"]))
    # Of two f0: 512 samples twice for indices, and 1000 samples, as for each of two shocks.
    counts = {"thresholds of devices as made": 2 * 512 * 2 + (2 + 2) * 1000}
    assert tolerances.application.counts(study) == counts
    product, written = xr.Dataset({"yield": 1.0}), []
    monkeypatch.setattr("snapmap.applications.tolerances.dataset.tolerances_of", lambda *_: product)
    monkeypatch.setattr("snapmap.study.variables.write_product", lambda *made: written.append(made))
    tolerances.application.run(study, "results/tolerance.nc")
    ((made, *_),) = written
    assert made["yield"].attrs == {"leaves_out": "srs, the closing of crash"}


def test_values_of_a_config_scatter_in_the_order_in_which_they_are_written():
    """Each draws by its place, so that another order would be other devices."""
    names = ["N", "thickness", "rise", "span"]
    document = yaml.safe_load(TINY) | {"tolerances": dict.fromkeys(names, "1 %")}
    assert [*load_config(document).requests["tolerances"].scatters] == names


def test_doubts_are_of_widths_and_of_samples_that_are_no_switch():
    document = yaml.safe_load(TINY) | {"tolerances": {"thickness": "60 %", "samples": 32}}
    wide, lost = tolerances.application.doubts(load_config(document))
    assert wide.startswith("thickness scatters by 60 %, more than 30 %; is ")
    assert lost.startswith("device: tolerances.thickness: a sample has the impossible value -0.1")


def test_there_are_no_more_samples_of_indices_than_of_all(handout):
    more = {"samples": 8, "index_samples": 9}
    line = "index_samples: 9 is more than samples, 8; write that or less"
    with pytest.raises(ValueError, match=f"^{line}$"):
        snapmap.tolerance(Study(handout, **CHEAP), {"thickness": 0.05}, 1500, 25, **more)
    document = yaml.safe_load(TINY) | {"tolerances": {"thickness": "1 %"} | more}
    assert faults(document) == [f"tolerances.{line}"]
    document["tolerances"]["index_samples"] = 8
    assert load_config(document).requests["tolerances"].power == 8


def test_a_share_of_which_some_may_count_or_not_has_the_bounds_of_both():
    found = dataset._share("met", np.array([[3.0]]), 8, ("C",), np.array([[2.0]]))
    low, high = (dataset.share_bounds(np.array([[count]]), 8) for count in (3.0, 5.0))
    assert found["met"][1] == 0.5 and found["met_bound"][0] == ("bound", "C")
    np.testing.assert_array_equal(found["met_bound"][1], [low[0], high[1]])

"""Devices as made: samples, thresholds, probability, sensitivity and yield."""

import warnings
from dataclasses import replace

import draw
import jobs
import numpy as np
import pytest
import xarray as xr
import yaml
from scipy import stats
from small_studies import THREE_COSINES

import snapmap
from snapmap.config.study import load_config
from snapmap.config.yaml_file import ConfigError
from snapmap.device import batch
from snapmap.figures.requirements import each_share
from snapmap.pulse import shocks_from
from snapmap.solver.adaptive import RUNGS
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from snapmap.tolerances import batch as batches
from snapmap.tolerances.batch import Batch, choose_builder
from snapmap.tolerances.dataset import summary
from snapmap.tolerances.samples import CUT, Plan
from snapmap.tolerances.sensitivity import crossed, indices
from snapmap.tolerances.statistics import (
    count_below,
    moments,
    quantile_bounds,
    quantiles,
    wilson,
)

CHEAP = {"model": "cosines", "modes": 3, "horizon": 300.0}
SETTINGS = {"name": "cosines", "modes": 3}


def vary(device, **values):
    return replace(device, beam=replace(device.beam, **values))


@pytest.mark.parametrize(
    ("given", "mean", "std"),
    [
        (0.05, 2.0, 0.05),
        ("5 %", 2.0, 0.1),
        ({"normal": "5 %"}, 2.0, 0.1),
        ({"uniform": 0.3}, 2.0, 0.3 / np.sqrt(3)),
        ({"lognormal": "30 %"}, 2.0, 0.6),
        ({"truncated": 0.1}, 2.0, 0.1 * stats.truncnorm.std(-CUT, CUT)),
    ],
)
def test_samples_have_the_moments_of_their_distribution(handout, given, mean, std):
    plan = Plan(handout, {"thickness": given})
    values = plan.values(plan.points(4096, seed=3)[0])["thickness"]
    assert values.mean() == pytest.approx(mean, rel=2e-3)
    assert values.std() == pytest.approx(std, rel=2e-2)


def test_samples_are_seeded_grow_and_move_together(handout):
    scatters = {"thickness": 0.05, "rise": "2 %", "depth": {"uniform": 0.1}}
    plan = Plan(handout, scatters, together=[["thickness", "depth"]])
    assert plan.names == ["thickness+depth", "rise"]
    few, many = plan.points(100, 7), plan.points(1000, 7)
    np.testing.assert_array_equal(few, many[:, :100])
    assert (plan.points(100, 8) != few).all()
    values = plan.values(many[0])
    assert stats.spearmanr(values["thickness"], values["depth"])[0] == pytest.approx(1)
    assert abs(stats.spearmanr(values["thickness"], values["rise"])[0]) < 0.05
    assert abs(stats.spearmanr(many[0, :, 0], many[1, :, 0])[0]) < 0.05


def test_indices_are_those_of_ishigamis_function():
    points = Plan(None, {"N": "1 %", "C": "1 %", "duration": "1 %"}).points(4096, seed=1)

    def ishigami(u):
        x = np.pi * (2 * u - 1)
        x1, x2, x3 = np.moveaxis(x, -1, 0)
        return (np.sin(x1) + 7 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1))[..., np.newaxis]

    mixed = ishigami(crossed(points))
    # Ishigami and Homma (1990): variances of the parts, with a = 7 and b = 0.1.
    both, lone, rest = 0.5 * (1 + np.pi**4 / 50) ** 2, 49 / 8, np.pi**8 / 1800 - np.pi**8 / 5000
    whole = both + lone + np.pi**8 * (1 / 18 - 1 / 50) / 100
    rest = whole - both - lone
    exact = np.array([[both, lone, 0], [both + rest, lone, rest]]) / whole
    found = indices(ishigami(points[0]), ishigami(points[1]), mixed, seed=5)[..., 0]
    np.testing.assert_allclose(found[:, 0], exact, atol=0.01)
    assert (found[:, 1] <= exact).all() and (exact <= found[:, 2]).all()
    same = indices(ishigami(points[0]), ishigami(points[1]), mixed, seed=5)[..., 0]
    np.testing.assert_array_equal(same, found)
    gone = ishigami(points[0])
    gone[[3, 70, 500]] = np.nan
    again = indices(gone, ishigami(points[1]), mixed, seed=5)[..., 0]
    np.testing.assert_allclose(again[:, 0], exact, atol=0.03)


@pytest.mark.parametrize("samples", [8, 100, 5000])
def test_bounds_of_a_share_are_wilsons(samples):
    for count in (0, 1, samples // 3, samples):
        known = stats.binomtest(count, samples).proportion_ci(method="wilson")
        np.testing.assert_allclose(wilson(count, samples), known, rtol=1e-9, atol=1e-12)


def test_statistics_count_what_never_snaps():
    N_first = np.array([[3.0], [1.0], [np.nan], [2.0]])
    assert count_below(N_first, np.array([0.5, 1, 2.5, 9])).tolist() == [[0, 1, 2, 3]]
    assert quantiles(N_first, [0.25, 0.5, 0.75])[:, 0].tolist() == [1, 2, 3]
    assert np.isnan(quantiles(N_first, [0.9])).all()
    mean, std = moments(N_first)
    assert (mean, std) == (2.0, 1.0)


def test_bounds_of_a_quantile_are_order_statistics():
    shares, N_first = [0.001, 0.05, 0.5, 0.95, 0.999], np.arange(1.0, 2996.0)[:, np.newaxis]
    low, high = quantile_bounds(N_first, shares)[..., 0]
    # 2995 samples are the fewest that bound these two, and 59 these.
    assert (low[0], high[-1]) == (1, 2995)
    assert np.isnan(quantile_bounds(N_first[:2994], shares)[[0, 1], [0, -1], 0]).all()
    assert quantile_bounds(N_first[:59], shares)[[0, 1], [1, 3], 0].tolist() == [1, 59]
    assert np.isnan(quantile_bounds(N_first[:58], shares)[[0, 1], [1, 3], 0]).all()
    # At 95 % each: of so many samples at least `low` lie below the median, and so on.
    assert stats.binom.sf(low[2] - 1, 2995, 0.5) >= 0.95 > stats.binom.sf(low[2], 2995, 0.5)
    assert stats.binom.cdf(high[2] - 1, 2995, 0.5) >= 0.95 > stats.binom.cdf(high[2] - 2, 2995, 0.5)
    assert (low[1:-1] < quantiles(N_first, shares)[1:-1, 0]).all()


def test_thresholds_are_those_of_the_devices_one_by_one(handout):
    scatters = {"thickness": "5 %", "youngs_modulus": "5 %", "duration": "3 %", "N": "2 %"}
    f0, C = [400.0, 1500.0, 4000.0], [25.0, 200.0]
    made = snapmap.tolerance(handout, scatters, f0, C, samples=100, seed=2, threads=2, **CHEAP)
    assert made.N_first.notnull().all() and (made.bistable == 1).all()
    for i in (0, 17, 80, 99):
        sample = made.isel(sample=i)
        values = {key: sample[key].item() for key in ("thickness", "youngs_modulus")}
        own = np.array(f0) / sample.duration_factor.item()
        alone = snapmap.threshold(vary(handout, **values), own, C, **CHEAP)
        off = abs(sample.N_first.values * sample.N_factor.item() / alone.N_first.values - 1)
        # Clean rows may hide an island as narrow as their bars.
        known = np.fmax(1.2e-3, (alone.N_error / alone.N_first).values)
        assert (off < known)[alone.ragged.values == 0].all()
        assert (off < 0.01).all() and (alone.ragged == 0).mean() >= 0.5


def test_small_scatter_adds_up_as_the_linear_estimate_says(handout):
    """Standard deviations and indices from the slopes, as docs/limits.md lists them."""
    scatters, f0 = {"thickness": "1 %", "youngs_modulus": "1 %", "rise": "1 %"}, [1500.0]
    made = snapmap.tolerance(
        handout, scatters, f0, [0.025], samples=1024, tolerance=1e-4, threads=2, **CHEAP
    )
    slopes = []
    for key in scatters:
        value = getattr(handout.beam, key)
        ends = {key: [0.99 * value, 1.01 * value]}
        N = snapmap.threshold(handout, f0, [0.025], tolerance=1e-6, **ends, **CHEAP).N_first
        slopes.append(float(np.log(N[1] / N[0]).item()) / np.log(1.01 / 0.99))
    linear = np.array(slopes) * 0.01
    spread = float((made.N_std / made.N_nominal).item())
    assert spread == pytest.approx(np.sqrt(np.sum(linear**2)), rel=0.02)
    share = linear**2 / np.sum(linear**2)
    np.testing.assert_allclose(made.sensitivity.sel(order="first").squeeze(), share, atol=0.02)
    np.testing.assert_allclose(made.sensitivity.sel(order="total").squeeze(), share, atol=0.02)
    low, high = made.sensitivity_bound.sel(order="first").squeeze().transpose("bound", "value")
    assert (low <= share).all() and (share <= high).all()


def test_the_share_that_snaps_lies_within_its_bounds(handout):
    plan = Plan(handout, {"thickness": "4 %", "youngs_modulus": "4 %"})
    settings = Settings(300.0, threads=2)

    def build(devices):
        return build_model(devices, **SETTINGS)

    def thresholds(samples, seed):
        batch = Batch(handout, plan.values(plan.points(samples, seed)[0]), build)
        return batch.thresholds(to_rows(0, 1500.0, 25.0), settings, 1e-3)[0]

    many = thresholds(4096, 1000)
    N = quantiles(many, [0.1, 0.5, 0.8])[:, 0]
    inside = np.zeros(3)
    for seed in range(100):
        few = thresholds(40, seed)
        low, high = wilson(count_below(few, N)[0], 40)
        inside += (low <= [0.1, 0.5, 0.8]) & (high >= [0.1, 0.5, 0.8])
    assert (inside >= 95).all()


def test_where_all_rows_are_ragged_the_finest_level_decides(handout, monkeypatch):
    """Each run of it changes the threshold."""
    seen = iter(np.arange(1.0, 9.0))
    monkeypatch.setattr(batches, "nominal_thresholds", lambda *_: np.full(2, next(seen)))
    rows = to_rows(0, [5e3, 9e3], 0.025)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        build = choose_builder(handout, {"name": "auto"}, rows, Settings())
    assert build(batch([handout])).modes == max(RUNGS)


def test_samples_without_a_second_shape_count_and_never_snap(handout):
    thin = vary(handout, rise=5.0)
    made = snapmap.tolerance(thin, {"thickness": {"uniform": "25 %"}}, [1500.0], [25.0],
                             samples=128, **CHEAP)  # fmt: skip
    lost = made.thickness > 5 * np.sqrt(3) / 4
    np.testing.assert_array_equal(made.bistable == 0, lost)
    assert 0.1 < lost.mean() < 0.5
    assert made.N_first.squeeze().isnull().where(lost, False).sum() == lost.sum()
    assert made.probability.max() == pytest.approx(1 - lost.mean().item())


def test_results_hang_neither_on_threads_nor_on_company(handout):
    asked = {"thickness": "5 %", "rise": "3 %"}, [800.0, 3000.0], [25.0]
    one = snapmap.tolerance(handout, *asked, samples=80, index_samples=16, **CHEAP)
    two = snapmap.tolerance(handout, *asked, samples=200, index_samples=16, threads=2, **CHEAP)
    np.testing.assert_array_equal(one.N_first, two.N_first[:80])
    np.testing.assert_array_equal(one.thickness, two.thickness[:80])


def test_shares_that_meet_requirements_are_those_of_the_thresholds(handout, monkeypatch):
    monkeypatch.setattr(batches, "FEWEST", 10)
    monkeypatch.setattr(batches, "FOLLOWED", 0)
    shocks = shocks_from("half sine", "+z")
    asked = [
        {"name": "trips", "shocks": shocks, "N": 1000.0, "f0": 2000.0, "snaps": True},
        {"name": "rests", "shocks": shocks, "N": 850.0, "f0": 1000.0, "snaps": False},
    ]
    brittle = replace(handout, strength=320.0)
    made = snapmap.tolerance(
        brittle, {"thickness": "5 %"}, [1500.0], [25.0], samples=100, requirements=asked, **CHEAP
    )
    first, rests = made.N_first_required.squeeze("C").values
    trips, quiet = first <= 1000 * 1.001, ~(rests <= 850)  # each the upper end of its step
    share = made.share_meeting.squeeze("C").values
    np.testing.assert_allclose(share, [trips.mean(), quiet.mean()], atol=0.011)
    followed = made.stress_max.squeeze("C").dropna("sample")
    good = (trips & quiet)[:10] & (followed <= 320).all("requirement").values
    assert 0 < good.sum() < (trips & quiet)[:10].sum()
    assert made["yield"].item() == pytest.approx(good.mean())
    assert made.yield_bound.values[0] < made["yield"].item() < made.yield_bound.values[1]
    assert followed.sizes["sample"] == 10
    np.testing.assert_allclose(made.share_breaking.squeeze("C"), (followed > 320).mean("sample"))
    assert 0 < made.share_breaking.values[0] < 1
    alone = vary(handout, thickness=made.thickness[0].item())
    run = snapmap.simulate(alone, 1000, 2000, 25, pulse="half sine", **CHEAP)
    assert run.stress_max == pytest.approx(followed.values[0, 0], rel=0.05)
    kept = snapmap.threshold(handout, [2000.0], [25.0], pulse="half sine", **CHEAP)
    assert np.interp(made.thickness.mean(), *np.sort([made.thickness, first])) == pytest.approx(
        kept.N_first.item(), rel=5e-3
    )


def test_what_stays_latched_is_told_of_a_damped_beam(handout):
    damped, N = vary(handout, damping=4e-3), np.array([900.0, 1100.0, 1400.0])
    asked = [1500.0], [200.0]
    followed = CHEAP | {"horizon": 4000.0}
    made = snapmap.tolerance(damped, {"thickness": "3 %"}, *asked, N=N, samples=32, **followed)
    assert (made.latched <= made.probability).all()
    cube = snapmap.sweep(
        damped, N, *asked, repeat=False, thickness=made.thickness.values, **followed
    )
    latched = (cube.outcome == 3).mean("thickness")
    np.testing.assert_allclose(made.latched.values, latched.values)
    plain = snapmap.tolerance(handout, {"thickness": "3 %"}, *asked, samples=16, **CHEAP)
    assert "latched" not in plain


def test_lowest_latched_is_where_the_cube_begins_to_latch_for_good(handout):
    damped, followed = vary(handout, damping=4e-3), CHEAP | {"horizon": 4000.0}
    found = snapmap.threshold(damped, [1500.0], [25.0, 200.0], highest=1600.0, **followed)
    assert (found.N_latched >= found.N_first).all()
    for C in found.C.values:
        N = np.geomspace(found.N_latched.sel(C=C).item(), 1600, 20)
        cube = snapmap.sweep(damped, N, [1500.0], [C], repeat=False, **followed)
        assert (cube.outcome == 3).mean() > 0.9
    bare = snapmap.threshold(handout, [1500.0], [0.025], **CHEAP)
    assert bare.N_latched.isnull().all()


@pytest.fixture
def document():
    sweep = {"N": [800, 1200], "f0": ["1 kHz"], "C": ["25 uN*us/um"], "horizon": "300 us"}
    return yaml.safe_load(THREE_COSINES) | {"sweep": sweep}


def test_tolerances_of_a_config_are_read_in_internal_units(document):
    asked = {
        "thickness": "50 nm",
        "youngs_modulus": "5.0 %",
        "rise": {"uniform": "0.2 um"},
        "N": "2 %",
        "together": [["thickness", "rise"]],
        "samples": 64,
    }
    read = load_config(document | {"tolerances": asked}).tolerances
    assert read.scatters["thickness"] == 0.05 and read.scatters["youngs_modulus"] == "5 %"
    assert read.scatters["rise"] == {"uniform": 0.2} and read.scatters["N"] == "2 %"
    assert (read.samples, read.seed, read.index_samples) == (64, 1, None)
    assert load_config(document).tolerances is None


@pytest.mark.parametrize(
    ("asked", "wanted"),
    [
        ({"thickness": "5 kg"}, "tolerances.thickness: '5 kg' does not convert to um"),
        ({"thickness": "120 %"}, "tolerances.thickness: '120 %' is not between 0 % and 100 %"),
        ({"thickness": {"gauss": "1 %"}}, "tolerances.thickness: a mapping is not of"),
        ({"thickness": {"normal": "1 %", "uniform": "1 %"}}, "tolerances.thickness: a mapping"),
        ({"N": "20 um"}, "tolerances.N: '20 um' is no share"),
        ({"width": "1 %"}, "tolerances.width: unknown key"),
        ({"thickness": "1 %", "together": [["thickness", "rise"]]}, "tolerances.together: rise"),
        ({"thickness": "1 %", "samples": 1}, "tolerances.samples: 1 is not a whole number"),
        ({"thickness": "1 %", "samples": 4, "index_samples": 8}, "tolerances.index_samples: 8"),
        ({"samples": 10}, "tolerances: name a value that scatters"),
        ({"damping": {"lognormal": "1 %"}}, "tolerances.damping: lognormal needs a nominal value"),
    ],
)
def test_tolerances_that_cannot_be_are_named_in_one_line(document, asked, wanted):
    with pytest.raises(ConfigError) as fault:
        load_config(document | {"tolerances": asked})
    assert str(fault.value).startswith(wanted) and "\n" not in str(fault.value)


def test_values_that_cannot_be_drawn_are_refused(handout):
    with pytest.raises(ValueError, match=r"thickness: -.* is drawn and cannot be"):
        snapmap.tolerance(handout, {"thickness": "70 %"}, [1500.0], [25.0], samples=64, **CHEAP)
    hard = replace(handout, contact=np.inf)
    with pytest.raises(ValueError, match="contact: a hard contact does not scatter"):
        snapmap.tolerance(hard, {"contact": "10 %"}, [1500.0], [25.0], **CHEAP)


def test_the_rules_write_and_draw_what_is_asked(document, tmp_path):
    device = document.pop("device")
    beam = device["beam"] | {"thickness": "1.9 um"}
    required = {"name": "drop", "shape": "half sine", "N": 900, "f0": "1 kHz", "snaps": True}
    shaking = {"name": "shaking", "psd": [["100 Hz", "0.1 g^2/Hz"], ["2 kHz", "0.1 g^2/Hz"]]}
    study = load_config(
        document
        | {
            "devices": {"one": device, "two": device | {"beam": beam}},
            "pulse": {"direction": "both"},
            "sweep": {
                "N": [800, 1000, 1200],
                "f0": ["800 Hz", "1500 Hz"],
                "C": ["25 uN*us/um"],
                "horizon": "300 us",
            },
            "tolerances": {"thickness": "0.05 um", "N": "2 %", "samples": 32, "seed": 1},
            "requirements": [required, shaking | {"duration": "10 ms", "snaps": False}],
        }
    )
    jobs.find_tolerance(study, tmp_path / "tolerance.nc")
    places = {"_one_+z": {"device": 0, "direction": 0}, "_two_-z": {"device": 1, "direction": 1}}
    yields = {"_one": {"device": 0}, "_two": {"device": 1}}
    draw.draw_tolerance(tmp_path / "tolerance.nc", places, yields, tmp_path)
    names = {f"{stem}{ending}" for stem in ("probability", "sensitivity") for ending in places}
    names |= {f"yield{ending}" for ending in yields}
    assert {path.stem for path in tmp_path.glob("*.pdf")} == names
    with xr.open_dataset(tmp_path / "tolerance.nc") as found:
        assert found.N_first.dims == ("device", "sample", "direction", "C", "f0")
        assert summary(found).startswith("64 samples")
        owed = found.sensitivity.where(
            found.direction == "+z", found.sensitivity.isel(value=-1) / 2
        )
        owed[{"direction": 1, "value": 1}] = 2.0
        told = summary(found.assign(sensitivity=owed))
        assert "most by thickness (one +z, two +z), most by N (one -z, two -z), yield" in told
        assert told.endswith(", without shaking")
        assert [name for name, *_ in each_share(found)] == ["drop", "all together, without shaking"]

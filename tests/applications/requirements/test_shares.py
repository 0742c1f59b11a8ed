"""Verdicts of a batch: shares of devices as made, all-fire and no-fire, against known ones."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
import yaml
from scipy import stats
from scipy.optimize import brentq
from small_results import drawn, legend_words, make_verdict
from small_studies import THREE_COSINES, cases_of, changed
from varied import varied

import snapmap
from snapmap.applications.requirements import application
from snapmap.applications.requirements.figure import draw_margins
from snapmap.applications.requirements.summary import missing_fire, of_batch, summary, with_shares
from snapmap.applications.requirements.verdict import read_verdicts
from snapmap.applications.tolerances import application as tolerances
from snapmap.applications.whole import load_config
from snapmap.device.device import batch as batch_of
from snapmap.numerics.statistics import share_bounds
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.adaptive import choose_model
from snapmap.solver.cells import to_cells
from snapmap.study.shock import Shock
from snapmap.study.study import Study

F0, C = [1500.0], [25.0]


def cheap(device):
    """A study by three cosines, to 300 us after a shock."""
    return Study(device, model={"name": "cosines", "modes": 3}, horizon=300.0)


def made_of(count, samples, confidence=0.95, C=25.0):
    """What a batch tells of one requirement, of whose devices so many meet it."""
    bounds = np.array(share_bounds(count, samples, confidence))[:, np.newaxis, np.newaxis]
    data = {"share_meeting": (("requirement", "C"), [[count / samples]])}
    data["share_meeting_bound"] = ("bound", "requirement", "C"), bounds
    return xr.Dataset(data, {"requirement": ["drop"], "C": [C]})


def judged(count, samples, share, confidence=0.95, word="met"):
    """The verdict on a shock that asks for a share."""
    asks = {"snaps": False, "share": share, "confidence": confidence}
    shock = Shock(name="drop", N=500.0, f0=1e3, shocks=make_shocks(), **asks)
    asked = [make_verdict(verdict=word, margin=1.5), make_verdict(requirement="vibration")]
    verdict, other = with_shares(asked, [shock], made_of(count, samples, confidence))
    assert np.isnan(other.share)
    return verdict


@pytest.mark.usefixtures("paper")
def test_a_share_decides_by_its_bounds_and_tells_what_would_decide():
    """99.9 % at 95 % takes 2995 devices without a failure, whatever the nominal device does."""
    met, few = judged(2995, 2995, 0.999, word="failed"), judged(2994, 2994, 0.999)
    assert (met.verdict, few.verdict, few.devices) == ("met", "unclear", 2995)
    assert np.isnan(met.devices) and met.share_asked == 0.999
    assert few.share_text.endswith(", asked 99.9 %, 2995 devices would decide")
    assert judged(100, 200, 0.9).verdict == "failed"
    beside = judged(56, 100, 0.0)
    assert (beside.verdict, beside.share) == ("met", 0.56) and np.isnan(beside.share_asked)
    assert beside.share_text == "56.0 % (47.3 to 64.4 %)"
    assert beside.verdict_text == "met by the nominal device" and met.verdict_text == "met"
    assert summary([few]) == "0 of 1 requirements met; unclear: drop"
    nominal = "1 of 1 requirements met (by the nominal device where no share is asked for)"
    assert summary([beside]) == nominal and summary([met]) == "1 of 1 requirements met"
    ax = drawn(draw_margins, [beside, replace(met, requirement="hit")])
    faces = [line.get_markerfacecolor() for line in ax.lines if line.get_marker() == "o"]
    words = ["met by the nominal device", "met", "threshold on the wrong side"]
    assert legend_words(ax) == words and faces == ["white", "black"]
    words = "share of the devices as made that meet drop 56.0 % (47.3 to 64.4 %)"
    assert of_batch([met, beside]) == words


def thickness_at(handout, N, low, high):
    """The thickness whose threshold is N, as the threshold rises with it."""

    def above(thickness):
        study = cheap(varied(handout, thickness=thickness))
        return snapmap.threshold(study, F0, C, tolerance=1e-5).N_first.item() - N

    return brentq(above, low, high, xtol=1e-4)


def test_bounds_hold_the_share_of_a_batch_that_is_known(handout):
    """Thickness alone scatters; its quantile at the required N is the share, without any draw."""
    N, mean, width = 1020.0, 2.0, 0.1
    edge = thickness_at(handout, N, mean - width, mean + width)
    share = (edge - mean + width) / (2 * width)
    assert 0.6 < share < 0.8
    trips, rests = ({"N": N, "f0": 1500.0, "snaps": snaps} for snaps in ("arrives", False))
    needs = [trips | {"name": "trips", "share": 0.6}, rests | {"name": "rests"}]
    held = []
    for seed in range(6):
        how = {"samples": 64, "index_samples": 2, "seed": seed, "requirements": needs}
        made = snapmap.tolerance(cheap(handout), {"thickness": {"uniform": width}}, F0, C, **how)
        trips, rests = made.share_meeting_bound.squeeze("C").transpose("requirement", ...).values
        held += [trips[0] <= share, share <= trips[1], rests[0] <= 1 - share <= rests[1]]
        estimate = made.share_meeting.sel(requirement="trips").item()
        assert abs(estimate - share) < 0.06  # 64 points of a sequence that fills the interval
    assert np.mean(held) >= 0.95


@pytest.mark.long
def test_bounds_hold_the_share_of_ten_thousand_independent_devices(handout):
    """Thickness, modulus and N scatter; devices are drawn one by one by another generator."""
    random, size = np.random.default_rng(7), 10_000
    scatters = {"thickness": 0.05, "youngs_modulus": "3 %", "N": "2 %"}
    thickness = 2.0 + 0.05 * random.standard_normal(size)
    modulus = handout.beam.youngs_modulus * (1 + 0.03 * random.standard_normal(size))
    factor = 1 + 0.02 * random.standard_normal(size)
    drawn = {"thickness": thickness, "youngs_modulus": modulus}
    devices = batch_of([handout]).pick(np.zeros(size, int)).vary(drawn)
    study, shares = cheap(handout), {}
    asked = {"most": (1100.0, "arrives"), "few": (850.0, False)}
    needs = [{"name": name, "N": N, "f0": 1500.0, "snaps": to} for name, (N, to) in asked.items()]
    for need in needs:
        cells = to_cells(devices, np.arange(size), need["N"] * factor, *F0, *C, 300.0)
        runs = choose_model(devices, study.model).follow(cells, study.run)
        shares[need["name"]] = (np.isfinite(runs.t_snap) == bool(need["snaps"])).mean()
    assert min(shares.values()) > 0.95 and max(shares.values()) < 0.998
    held = []
    for seed in range(20):
        how = {"samples": 250, "index_samples": 2, "seed": seed, "requirements": needs}
        made = snapmap.tolerance(cheap(handout), scatters, F0, C, **how).squeeze()
        for name, share in shares.items():
            low, high = made.share_meeting_bound.sel(requirement=name).values
            held += [low <= share, share <= high]
    assert np.mean(held) >= 0.95


def test_no_fire_and_all_fire_are_order_statistics_or_say_how_many_devices_they_take(handout):
    """90 % at 90 % takes 22 devices: the lowest and the highest of them."""
    need = {"name": "a", "N": 1e3, "f0": 1500.0, "snaps": "arrives", "share": 0.9}
    need["confidence"] = 0.9
    scatter = {"thickness": "3 %"}
    for samples in (22, 21):
        how = {"samples": samples, "index_samples": 2, "requirements": [need]}
        made = snapmap.tolerance(cheap(handout), scatter, F0, C, **how).squeeze()
        ends = made.N_no_fire, made.N_all_fire
        if samples == 22:
            first = made.N_first.values
            assert ends[1] == first.max() and ends[0] == pytest.approx(first.min(), rel=1.1e-3)
            assert ends[0] < first.min() and missing_fire(ends[1], samples) == ""
        else:
            assert np.isnan(ends).all() and missing_fire(ends[1], samples) == "takes 22 devices"
        assert (ends[0].share, ends[0].confidence) == (0.9, 0.9)


def test_all_fire_holds_for_other_devices_of_its_batch(handout):
    """Of batches of 59 devices at least 95 % bound the level that 95 % of devices reach."""
    scatter = {"thickness": "3 %"}
    need = {"name": "a", "N": 1e3, "f0": 1500.0, "snaps": "arrives", "share": 0.95}
    many = {"samples": 1024, "index_samples": 2}
    N_first = snapmap.tolerance(cheap(handout), scatter, F0, C, **many).N_first
    low, high = np.quantile(N_first, [0.05, 0.95])
    held = []
    for seed in range(2, 12):
        how = {"samples": 59, "index_samples": 2, "seed": seed, "requirements": [need]}
        made = snapmap.tolerance(cheap(handout), scatter, F0, C, **how).squeeze()
        held += [made.N_all_fire.item() >= high, made.N_no_fire.item() <= low]
    assert np.sum(held) >= stats.binom.ppf(0.05, len(held), 0.95)


def test_the_table_and_the_last_line_have_the_share(tmp_path, capsys):
    study = load_config(changed(yaml.safe_load(THREE_COSINES), **cases_of(__file__)))
    made, path = tmp_path / "tolerance.nc", tmp_path / "requirements.csv"
    tolerances.run(study, made)
    application.run(study, path, made)
    (row,) = read_verdicts(path)
    assert row.share_asked == 0.8 and row.share_low < row.share < row.share_high
    with xr.open_dataset(made) as batch:
        assert row.share == batch.share_meeting.item()
    words = capsys.readouterr().out
    assert f"share of the devices as made that meet crash {row.share_text}" in words
    assert application.inputs(study) == {"tolerance": "results/tolerance.nc"}

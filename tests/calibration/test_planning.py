"""The next shot, what shots say of thresholds, and how many show a demand."""

import numpy as np
import pytest
from scipy.special import log_ndtr, ndtri
from scipy.stats import binom, f

import snapmap
from snapmap.calibration.planning import best, estimate, has_estimate, next_level

STANDARD = [1.0, 1.2, 1.4, 1.8, 2.6, 4.2, 3.4, 3.8, 4.0, 4.1]
STANDARD += [4.28, 4.52, 5.55, 5.24, 6.37, 6.08, 7.38, 7.09, 6.89, 6.74]
STANDARD = np.array(STANDARD), np.array([one == "1" for one in "00000100000010101111"])
"""Neyer's test of MIL-STD-331, appendix G; ends 0.6 and 1.4, guessed spread 0.1."""
GONOGO = [600, 650, 625, 612, 606, 590, 593, 611, 617, 599, 590, 616, 593, 584, 585, 615, 587]
GONOGO += [613, 612, 589, 611, 590, 610, 591, 609]
GONOGO = np.array(GONOGO, float), np.array([one == "1" for one in "0111100011011001011010101"])
"""A test of the R package gonogo, and the levels that it asked for before rounding."""
ASKED = [616.8731, 599.4648, 590.4793, 615.7384, 592.9877, 583.6982, 585.3147, 615.2118, 587.4391]
ASKED += [613.3351, 612.3336, 589.3771, 611.0667, 590.4844, 610.0713, 591.3679, 609.2816]


def test_the_levels_of_neyers_test_are_those_of_the_standard():
    N, tripped = STANDARD
    told = [next_level(N[:n], tripped[:n], "neyer", 0.6, 1.4, 0.1) for n in range(N.size)]
    np.testing.assert_allclose([level for level, _ in told], N, atol=0.005)
    phases = [why.split(":")[0] for _, why in told[1:]]
    assert phases == ["find"] * 9 + ["overlap"] + ["estimate"] * 9


def test_d_optimal_levels_and_the_fit_are_those_of_gonogo():
    N, tripped = GONOGO
    told = [next_level(N[:n], tripped[:n], "neyer", 0, 1, 1)[0] for n in range(8, N.size)]
    np.testing.assert_allclose(told, ASKED, atol=0.006)
    np.testing.assert_allclose(best(N, tripped), [600.383131, 7.894673], rtol=1e-5)


def test_intervals_end_where_the_likelihood_ratio_is_that_of_f():
    N, tripped = GONOGO
    told = estimate(N, tripped, 0.9)
    mean, sigma = np.meshgrid(np.linspace(575, 625, 401), np.geomspace(2, 60, 401))
    sign = np.where(tripped, 1, -1)
    loss = -sum(log_ndtr(s * (n - mean) / sigma) for n, s in zip(N, sign, strict=True))
    inside = loss - loss.min() < f.ppf(0.9, 1, N.size - 2) / 2
    levels = [mean + z * sigma for z in ndtri([0.001, 0.999])]
    for one, values in zip(told, (mean, sigma, *levels), strict=True):
        ends = values[inside].min(), values[inside].max()
        np.testing.assert_allclose(one[1:], ends, atol=0.02 * (one.high - one.low))
        assert one.low < one.value < one.high


def test_what_shots_leave_open_is_infinite():
    N, tripped = np.array([10.0, 12.0, 11.0, 13.0]), np.array([False, False, True, True])
    told = estimate(N, tripped, 0.95)
    assert told.all_fire.high == told.sigma.high == np.inf and told.no_fire.low == -np.inf
    assert not has_estimate(N, ~tripped) and not has_estimate(N, N > 11.5)


def test_up_and_down_takes_one_step_against_the_answer():
    N, tripped = np.array([20.0, 19.5]), np.array([True, False])
    told = [next_level(N[:n], tripped[:n], "up-and-down", 0, 1, 0.5)[0] for n in (1, 2)]
    assert told == [19.5, 20.0]


@pytest.mark.parametrize(
    ("reliability", "counts"),
    [(0.9, [29, 46, 61, 76, 89]), (0.95, [59, 93, 124]), (0.99, [299, 473, 628]), (0.999, [2995])],
)
def test_shots_needed_are_those_of_the_tables(reliability, counts):
    assert [snapmap.shots_needed(reliability, 0.95, k) for k in range(len(counts))] == counts
    for failures, shots in enumerate(counts):
        below, at = binom.sf(failures, [shots - 1, shots], 1 - reliability)
        assert below < 0.95 <= at


def test_the_plan_begins_at_the_models_threshold(tmp_path):
    made = snapmap.plan_shots((1000.0, 50.0))
    assert made.N == 1000 and made.estimate is None
    path = tmp_path / "shots.csv"
    rows = "\n".join(f"{n:g},{went}" for n, went in zip(*GONOGO, strict=True))
    path.write_text(f"N,tripped\n{rows}\n")
    columns = {"N": GONOGO[0], "tripped": GONOGO[1]}
    told = [snapmap.plan_shots((600.0, 15.0), one) for one in (path, columns)]
    assert told[0] == told[1] and told[0].estimate.mean.value == pytest.approx(600.383131)

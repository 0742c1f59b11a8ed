"""Bounds of shares: closed numbers, exact tests, and how many devices decide."""

import numpy as np
import pytest
import xarray as xr
from scipy import stats

from snapmap.numerics.statistics import devices_to_decide, percents, scope, share_bounds


@pytest.mark.parametrize(("samples", "confidence"), [(8, 0.95), (100, 0.9), (5000, 0.99)])
def test_each_bound_is_that_of_the_exact_test_of_its_side(samples, confidence):
    for count in (0, 1, samples // 3, samples):
        tests = (stats.binomtest(count, samples, alternative=side) for side in ("greater", "less"))
        low, high = (test.proportion_ci(confidence)[end] for end, test in enumerate(tests))
        np.testing.assert_allclose(share_bounds(count, samples, confidence), (low, high), atol=1e-7)


def test_bounds_hold_at_their_confidence_or_more():
    """Of all batches of 50 devices: the probability of those whose bound holds, at any share."""
    low, high = share_bounds(np.arange(51), 50)
    for share in (0.003, 0.2, 0.5, 0.77, 0.99):
        chance = stats.binom.pmf(np.arange(51), 50, share)
        assert chance[low <= share].sum() >= 0.95 and chance[share <= high].sum() >= 0.95


def test_devices_that_decide_are_the_first_that_do():
    """Without a failure 99.9 % takes 2995 devices, as 0.999^2995 is the first below 5 %."""
    assert devices_to_decide(1.0, 0.999) == 2995
    assert share_bounds(2995, 2995)[0] >= 0.999 > share_bounds(2994, 2994)[0]
    assert devices_to_decide(1.0, 0.9, 0.99) == 44 and devices_to_decide(0.0, 0.9) == 2
    for share, asked in ((0.8, 0.75), (0.7, 0.75)):
        size = devices_to_decide(share, asked)
        before, after = (share_bounds(share * n, n) for n in (size - 1, size))
        assert before[0] < asked <= before[1] and not after[0] < asked <= after[1]
    assert devices_to_decide(0.75, 0.75) == np.inf


def test_no_share_reads_as_all_or_none_that_is_not():
    words = percents(1.0), percents(0.0), percents(0.56), percents(0.999)
    assert words == ("100.0 %", "0.0 %", "56.0 %", "99.9 %")
    assert percents(0.9996) == "99.96 %" and percents(0.0007) == "0.07 %"
    assert percents(0.99999, np.nan, 1.0) == "99.999 to 100.0 %" and percents(np.nan) == "not known"


def test_a_yield_tells_where_it_holds_and_what_it_leaves_out():
    attributes = {"temperatures": "20 degC", "leaves_out": "breaking"}
    assert scope(xr.DataArray(attrs=attributes)) == ", at 20 degC, without breaking"
    assert scope(xr.DataArray()) == ""

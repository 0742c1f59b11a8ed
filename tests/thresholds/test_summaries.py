"""Thresholds in a line and in a table, parts of rows put together, and where rows are searched."""

import numpy as np
import pytest
import xarray as xr
from small_studies import cases_of

from snapmap.thresholds.edges import Edges
from snapmap.thresholds.summary import summary, tidy, to_digits
from snapmap.thresholds.survey import _spread, with_rows
from snapmap.thresholds.verified import _places

CASES, NAN = cases_of(__file__), np.nan
FOUND, AXES = CASES["found"], CASES["axes"]


@pytest.fixture
def found():
    return xr.Dataset({key: ([*AXES], values) for key, values in FOUND.items()}, AXES)


@pytest.mark.parametrize(("ends", "direction", "f0", "line"), CASES["lines"])
def test_thresholds_are_summed_up_in_a_line(found, ends, direction, f0, line):
    assert summary(found.isel(direction=direction, f0=f0), *ends) == line


def test_each_threshold_has_a_row_with_its_place_and_status_in_words(found):
    table = tidy(found.assign(area=0.5, island_from=("island", [1.0])))
    assert [*table] == [*AXES, "duration", *FOUND, "area"] and table.area.tolist() == [0.5] * 6
    assert table.duration.tolist() == [1.0, 0.5, float("0.333333333333")] * 2
    words = ["found", "not_followed", "found", "found", "found", "nothing_snaps"]
    assert table.status.tolist() == words


@pytest.mark.parametrize(("N", "error", "words"), CASES["digits"])
def test_a_threshold_has_as_many_digits_as_its_error_allows(N, error, words):
    assert to_digits(N, error) == words


@pytest.mark.parametrize(("size", "halvings", "places"), CASES["places"])
def test_places_that_are_searched_lie_evenly_and_twice_as_dense_after_a_halving(
    size, halvings, places
):
    assert _places(np.arange(size), halvings).tolist() == places


def test_rows_take_new_values_and_keep_others():
    assert with_rows(4, np.array([1, 3]), np.array([5, 6]), None).tolist() == [0, 5, 0, 6]
    short, long = np.array([[7.0]]), np.array([[1.0, 2.0], [3.0, 4.0]])
    made = with_rows(2, np.array([1]), short, long), with_rows(2, np.array([1]), long[:1], long)
    np.testing.assert_array_equal(made, [[[1, 2], [7, NAN]], [[1, 2], [1, 2]]])


def test_the_spread_of_a_row_ends_at_its_last_change_within_a_fiftieth():
    ends = [1.0, 1.01, 1.1, 2.0], [1.001, 1.019, 1.2, 2.01]
    edges = Edges(np.array([0, 0, 0, 1]), *map(np.array, ends), np.array([1, 0, 1, 1], bool))
    assert _spread(edges, np.array([1.001, 2.01])) == pytest.approx([0.009, 0.0])

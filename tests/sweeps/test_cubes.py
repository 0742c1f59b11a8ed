"""What a cube says of its cells: wells, agreement of two runs, counts, and its last line."""

import numpy as np
import pytest
import xarray as xr
from small_results import VARIABLES, make_cells
from small_studies import cases_of

from snapmap.solver.cells import no_observations, to_rows
from snapmap.solver.options import TOLERANCE
from snapmap.solver.outcome import ABSENT, OUTCOMES
from snapmap.solver.settings import Run
from snapmap.sweeps.cube import SHOWN_CELLS, label_distance, summary, thin, with_summary
from snapmap.sweeps.slabs import follow_rows


class Told:
    """A model whose single cell shows what it is told: in its step, and in another."""

    def __init__(self, device, *runs):
        self.device, self.runs = device, runs

    def follow(self, cells, settings):
        seen = {"energy_error": 0.0, "pulse_work": 1.0, "well_share": 1.0} | self.runs[0]
        return no_observations((1, 1))._replace(**{key: np.full((1, 1), seen[key]) for key in seen})

    def with_step(self, factor):
        return Told(self.device, *self.runs[1:])


@pytest.mark.parametrize(("start", "one", "other", "told"), cases_of(__file__))
def test_a_cell_has_the_well_of_its_end_and_whether_another_step_agrees(
    handout, start, one, other, told
):
    """A well counts in the order of the device's shapes; without one the label is compared."""
    rows = to_rows([0, -1], 1500.0, 25.0)
    made = follow_rows(Told(handout, one, other), rows, [9.0], Run(start=start))
    keys = "well", "well_reproduced", "reproduced", "well_share"
    each = np.transpose([made[key].ravel() for key in keys])
    np.testing.assert_array_equal(each, [told, [0, 1, 1, np.nan]])  # the other has no device


def test_labels_near_a_change_are_expected_by_the_distances_of_N():
    """Of each change 2 * 0.1 N over the distance to the next N: twice 2, and four times 0.55."""
    cells = make_cells(["3333", "1111", "3311"], N=np.array([1000.0, 1100.0, 1500.0]))
    cells.t_snap.attrs["label_distance"] = 0.1
    near = "about 6 within 10 % of a threshold, of uncertain label"
    line = f"12 cells, all settled; {near}; 6 never, 6 latched, 0 failed"
    assert summary(with_summary(cells.isel(N=[2, 0, 1]))) == line


def test_all_but_one_of_ten_thousand_are_a_share_rounded_down():
    cells = make_cells(["1111"] * 2499 + ["1110"])
    cells["well_reproduced"] = cells.outcome
    line = "10000 cells, 99.9 % settled; 1 on another side with a smaller time step"
    assert summary(with_summary(cells)).startswith(line)


@pytest.mark.parametrize(("row", "words"), [("1234", OUTCOMES[:ABSENT]), ("1236", OUTCOMES)])
def test_only_a_cube_that_lacks_a_device_has_a_code_for_that(row, words):
    cells = make_cells([row])
    cells.outcome.attrs = dict(VARIABLES["outcome"])
    assert with_summary(cells).outcome.flag_meanings.split() == [*words]


def test_a_distance_of_labels_is_that_of_the_model():
    models = {"name": "auto"}, {"name": "auto", "tolerance": 0.01}, {"name": "cosines"}, {"laws": 1}
    assert [*map(label_distance, models)] == [2 * TOLERANCE, 0.02, 0.01, None]


SHAPES = {(3, 300, 200): (3, 100, 100), (2, 100, 200): (2, 100, 200), (1, 40001): (1, 20001)}


def test_a_large_cube_is_thinned_along_its_longest_axes():
    for shape, left in SHAPES.items():
        cube = xr.Dataset({"outcome": (("C", "f0", "N")[: len(shape)], np.zeros(shape))})
        assert thin(cube).outcome.shape == left and np.prod(left) <= SHOWN_CELLS

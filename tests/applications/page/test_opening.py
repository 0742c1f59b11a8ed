"""Where a page opens."""

import xarray as xr
from small_results import make_cells

from snapmap.applications.page.figure import _opening


def test_it_opens_at_the_threshold_on_a_cell_that_ends_alike_in_other_steps():
    cells = make_cells(["22", "22", "00"])
    for sure in (0, 1):
        cells["well_reproduced"] = xr.zeros_like(cells.outcome)
        cells.well_reproduced[sure] = 1
        assert _opening(cells, "f0", "N") == [sure, 1]

"""The figure of measured shots."""

import pytest
import xarray as xr
from small_results import drawn

from snapmap.applications.calibration import figure as calibration

pytestmark = pytest.mark.usefixtures("paper")


def test_shots_stand_on_the_side_of_their_outcome_beside_the_fit():
    spread = xr.DataArray([0.05], dims="bound", coords={"bound": ["estimate"]})
    columns = {"f0": [1e3, 1e3, 2e3], "N": [900.0, 1100.0, 1000.0], "tripped": [0, 1, 0]}
    columns |= {"threshold": [1e3, 1e3, 1.2e3], "threshold_low": [950.0, 950.0, 1100.0]}
    columns |= {"threshold_high": [1050.0, 1050.0, 1300.0], "direction": ["+z"] * 3}
    columns["shape"] = ["half sine"] * 3
    found = xr.Dataset({key: ("shot", values) for key, values in columns.items()})
    (panel,) = calibration.panels(found.assign(spread=spread))
    fit, stayed, tripped = drawn(calibration.draw_shots, panel).lines
    assert fit.get_xydata().tolist() == [[1e3, 1e3], [2e3, 1.2e3]]
    assert stayed.get_ydata().tolist() == [900, 1000] and tripped.get_ydata().tolist() == [1100]
    assert [shots.get_markerfacecolor() for shots in (stayed, tripped)] == ["white", "black"]

"""Cubes that others have made or changed: named in one line, not misread."""

import numpy as np
import pytest
from small_results import TINY, make_cells

import snapmap

CHANGES = {
    "lost its attribute flag_meanings": lambda cube: cube.drop_attrs(),
    "has no codes of outcomes": lambda cube: cube.assign(outcome=cube.outcome.astype(str)),
    "-1 is not a code of an outcome; codes are 0 to 6": lambda cube: with_code(cube, -1),
    "8 is not a code of an outcome; codes are 0 to 6": lambda cube: with_code(cube, 8),
    "N is an axis of numbers, but": lambda cube: cube.assign_coords(N=[np.nan, 1, 2, 3]),
    "f0 is an axis of numbers, but": lambda cube: cube.assign_coords(f0=[*"abcd"]),
    "its attribute config is not JSON": lambda cube: cube.assign_attrs(config="model: auto"),
}


def with_code(cube, code):
    outcome = cube.outcome.copy()
    outcome[0, 0] = code
    return cube.assign(outcome=outcome)


@pytest.mark.parametrize("words", CHANGES)
def test_a_changed_cube_is_refused_in_one_line(tmp_path, words):
    cube, path = CHANGES[words](TINY), tmp_path / "cube.nc"
    cube.to_netcdf(path)
    for name, function, given in (
        (str(path), snapmap.open_cube, path),
        ("cube", snapmap.plot_outcome, cube),
    ):
        with pytest.raises(ValueError) as refusal:
            function(given)
        assert str(refusal.value).startswith(f"{name}: ") and words in str(refusal.value)
        assert "\n" not in str(refusal.value)


def test_a_cube_that_was_opened_and_written_again_is_one(tmp_path):
    cube = make_cells(["0123"]).drop_attrs(deep=False)
    cube.to_netcdf(tmp_path / "one.nc")
    opened = snapmap.open_cube(tmp_path / "one.nc")
    opened.to_netcdf(tmp_path / "other.nc")
    assert snapmap.open_cube(tmp_path / "other.nc").identical(opened)
    snapmap.plot_outcome(opened.assign_attrs(config="{}"))

"""What other tools and notebooks are given: tables, outcomes in words, an installed package."""

import tomllib
from fnmatch import fnmatch

import numpy as np
import pytest

import snapmap
from snapmap.solver.outcome import OUTCOMES
from snapmap.study.netcdf import write
from snapmap.thresholds.rows import tidy

CHEAP = {"model": "cosines", "modes": 3, "horizon": 300.0}


def test_each_threshold_is_a_row(handout):
    found = snapmap.threshold(handout, [500.0, 1500.0], [25.0], thickness=[1.9, 2.0], **CHEAP)
    table = tidy(found)
    assert [*table.columns[:4]] == ["thickness", "C", "f0", "duration_ms"]
    assert len(table) == 4 and "island_from" not in table
    for _, row in table.iterrows():
        one = found.sel(thickness=row.thickness, C=row.C, f0=row.f0)
        assert row.N_first == one.N_first.item() and row.N_error == one.N_error.item()
        assert row.N_static == one.N_static.item() and row.duration_ms == 1e3 / row.f0


@pytest.fixture(scope="module")
def cube(handout):
    return snapmap.sweep(handout, [800, 1000, 1300], [800, 1500], [25, 200], **CHEAP)


def test_an_opened_cube_has_outcomes_in_words(cube, tmp_path):
    write(cube, tmp_path / "cube.nc")
    opened = snapmap.open_cube(tmp_path / "cube.nc")
    np.testing.assert_array_equal(opened.outcome_code, cube.outcome)
    assert (opened.outcome == np.array(OUTCOMES)[cube.outcome.values]).all()
    with pytest.raises(ValueError, match=r"none\.nc' is not the path of a file"):
        snapmap.open_cube(tmp_path / "none.nc")
    held = bytearray((tmp_path / "cube.nc").read_bytes())
    for place in (0, 50, len(held) // 2, len(held) - 1):
        (tmp_path / "bad.nc").write_bytes(
            held[:place] + bytes([held[place] ^ 1]) + held[place + 1 :]
        )
        with pytest.raises(ValueError, match=r"bad\.nc: is damaged; take another copy"):
            snapmap.open_cube(tmp_path / "bad.nc")


def test_a_plot_of_an_opened_cube_is_that_of_a_new_one(cube, tmp_path):
    with pytest.raises(ValueError, match="several C"):
        snapmap.plot_outcome(cube)
    write(cube, tmp_path / "cube.nc")
    both = cube.isel(C=0), snapmap.open_cube(tmp_path / "cube.nc").isel(C=0)
    drawn = [
        [(one.get_facecolor(), one.get_path().vertices.tolist()) for one in ax.patches]
        for ax in map(snapmap.plot_outcome, both)
    ]
    assert drawn[0] == drawn[1]


def test_the_installed_package_has_all_its_files(root):
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    patterns = project["tool"]["setuptools"]["package-data"]
    package = root / "workflow" / "scripts" / "snapmap"
    for path in package.rglob("*"):
        if path.is_file() and path.suffix not in (".py", ".pyc", ".nbi", ".nbc"):
            assert any(fnmatch(path.name, one) for one in patterns["*"]), path

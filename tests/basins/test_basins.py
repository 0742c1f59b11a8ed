"""Integrity, entropy and uncertainty exponent of labelled maps."""

import draw_integrity
import measure_integrity
import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad
from scipy.special import entr
from small_results import make_cells

import snapmap
from snapmap.basins.entropy import (
    basin_entropy,
    disk_entropy,
    uncertain_shares,
    uncertainty_exponent,
)
from snapmap.basins.integrity import distances
from snapmap.io.netcdf import write

SMOOTH = 0.4395093
"""Boundary entropy of a smooth boundary on two axes, in the tests of Attractors.jl."""


def exponent(labels, sizes):
    return uncertainty_exponent(sizes, uncertain_shares(labels, sizes))[0]


def grebogi(points):
    """The map of Grebogi et al. (1983), whose basins are those of 0 and pi."""
    angle, x = np.meshgrid(
        np.linspace(0, 2 * np.pi, points), np.linspace(-0.5, 0.5, points), indexing="ij"
    )
    for _ in range(50):
        turned = 1.32 * np.sin(2 * angle) - 0.9 * np.sin(4 * angle) - x * np.sin(angle)
        angle, x = (angle + turned) % (2 * np.pi), -0.3 * np.cos(angle)
    return (np.cos(angle) > 0).astype(int)


def newton(points):
    """Which cube root of 1 Newton's method finds."""
    side = np.linspace(-1, 1, points)
    z = side[:, np.newaxis] + 1j * side
    for _ in range(25):
        z = z - (z**3 - 1) / (3 * z**2)
    return np.round(np.angle(z)).astype(int)


def test_a_half_plane_has_exponent_1_and_a_known_entropy():
    half = np.zeros((120, 120), int)
    half[:61] = 1
    assert exponent(half, [2, 4, 6, 8, 12]) == pytest.approx(1)
    of_box = entr(1 / 12) + entr(11 / 12)
    np.testing.assert_allclose(basin_entropy(half, 12), (of_box / 10, of_box))
    assert exponent(half[:, 0], [2, 4, 6, 8]) == pytest.approx(1)


def test_a_checkerboard_is_as_uncertain_as_two_labels_can_be():
    board = np.indices((60, 60)).sum(axis=0) % 2
    np.testing.assert_allclose(basin_entropy(board, 6), (np.log(2), np.log(2)))
    assert exponent(board, [3, 5, 7]) == pytest.approx(0, abs=1e-12)
    assert basin_entropy(0 * board, 6) == (0.0, pytest.approx(np.nan, nan_ok=True))


def test_a_smooth_boundary_has_the_entropy_of_a_disk_cut_at_random():
    def of_cut(height):
        part = (np.arccos(height) - height * np.sqrt(1 - height**2)) / np.pi
        return entr(part) + entr(1 - part)

    assert quad(of_cut, 0, 1)[0] == pytest.approx(SMOOTH, abs=1e-7)
    i, j = np.indices((200, 200))
    for radius in (5, 10, 20):
        found = disk_entropy((j + 0.37 * i > 137).astype(int), radius)
        assert SMOOTH < found < SMOOTH + 0.224 / radius
    assert disk_entropy((np.arange(2001) > 900).astype(int), 200) == pytest.approx(0.5, abs=0.01)


def test_fractal_maps_have_the_values_that_attractors_jl_is_tested_for():
    assert 0.2 <= exponent(grebogi(251), range(3, 16)) <= 0.3
    assert 0.55 <= exponent(newton(300), range(5, 31)) <= 0.65
    finer = grebogi(300)
    whole, boundary = basin_entropy(finer, 6)
    assert 0.4 <= whole <= 0.42 and 0.6 <= boundary <= 0.61
    assert disk_entropy(finer, 5) > SMOOTH + 0.224 / 5


def test_distances_in_a_disk_are_those_to_its_edge():
    x, y = np.meshgrid(np.linspace(-1, 1, 201), np.linspace(-1, 1, 101), indexing="ij")
    inside = x**2 + y**2 < 0.64
    far = distances(inside.astype(int), [2 / 200, 2 / 100])
    assert abs(far - abs(np.hypot(x, y) - 0.8)).max() < 0.03
    assert np.isinf(distances(0 * inside, [1, 1])).all()


def test_the_integrity_of_a_cube_is_that_of_its_labels():
    cells = make_cells(["3335", "3343", "1333", "1113", "1111"])
    found = snapmap.integrity(cells.expand_dims(C=[25.0]))
    snaps, ends = found.basins.isel(C=0).transpose("labels", "N", "f0").values[:, ::-1]
    assert snaps.tolist()[:3] == [[2, 2, 2, -1], [2, 2, 2, 2], [1, 2, 2, 2]]
    assert ends.tolist()[1] == [2, 2, 1, 2] and found.basins.dtype == np.int8
    told = found.isel(C=0).sel(labels="snaps")
    to_the_snap = snapmap.integrity(cells.drop_vars("well").expand_dims(C=[25.0]))
    xr.testing.assert_equal(to_the_snap, found.sel(labels=["snaps"]))
    np.testing.assert_allclose(told.safe_share, [1, 0.75, 0.25, 0, 0])
    # f0 has four points, N five: a cell is a third wide and a quarter high.
    assert told.integrity.isel(f0=0, N=0).item() == pytest.approx(np.hypot(1 / 3, 1 / 2))
    assert told.safe_distance.isel(N=1).item() == pytest.approx(np.hypot(1 / 3, 1 / 4))
    with pytest.raises(ValueError, match=r"^N: no values evenly apart"):
        snapmap.integrity(cells.isel(N=[0, 1, 2, 4]))
    with pytest.raises(ValueError, match=r"^box: 5 is not from 2 to the 4 cells"):
        snapmap.integrity(cells, box=5)


def test_the_scripts_of_its_rules_measure_and_draw(tmp_path):
    rows = ["3333", "3343", "1333", "1113", "1111"]
    write(make_cells(rows).expand_dims(C=[25.0]), tmp_path / "cube.nc")
    measure_integrity.measure_integrity(tmp_path / "cube.nc", tmp_path / "integrity.nc")
    draw_integrity.draw_integrity(tmp_path / "integrity.nc", str(tmp_path / "integrity"))
    assert {path.suffix for path in tmp_path.glob("integrity.*")} == {".nc", ".pdf", ".png"}

"""The figure of the damage boundary."""

import numpy as np
import pytest
from matplotlib.patches import Polygon
from small_results import artists, drawn, legend_words, make_found, visible

from snapmap.applications.boundary.figure import DURATION, draw_damage_boundary


@pytest.fixture
def ax(paper):
    return drawn(draw_damage_boundary, make_found())


def test_what_snaps_of_each_C_is_shaded(ax):
    region, other = artists(ax, Polygon)
    assert legend_words(ax)[-1] == "snaps, in the colour of its line"
    assert other.get_path().vertices[0, 1] == region.get_path().vertices[0, 1] + 1
    assert region.get_zorder() < min(line.get_zorder() for line in ax.lines)
    snaps = region.get_path().contains_points
    assert snaps([(1.1, 2000.0), (6.0, 1100.0), (50.0, 1010.0), (51.0, 1e5)]).all()
    assert not snaps([(0.9, 1900.0), (5.4, 1000.0), (50.0, 980.0)]).any()
    # Shorter and longer pulses than the curve has.
    assert not snaps([(0.6, 1e5), (1.0, 2100.0), (1e3, 1000.0), (51.0, 1010.0)]).any()


def test_thresholds_lie_over_the_velocity_change_between_their_limits(ax):
    # N g / (2 f0), with g = 10 m/s^2
    during, late = map(visible, ax.lines[1:3])
    assert during == [pytest.approx([50.0, 1000.0]), pytest.approx([5.5, 1100.0])]
    assert late == [pytest.approx([5.5, 1100.0]), pytest.approx([1.0, 2000.0])]
    assert ax.get_xscale() == ax.get_yscale() == "log"
    lines = [line.get_xydata().T.tolist() for line in ax.lines]
    upright, level = ([ends[i][0] for ends in lines if ends[1 - i] == [0, 1]] for i in (0, 1))
    assert (upright, level) == ([0.5, 0.6], [990.0])
    guides = [line for line in ax.lines if line.get_color() == DURATION["color"]]
    v, N = guides[1].get_xydata().T
    assert len(guides) == 3 and N * 1e-5 / v == pytest.approx(np.full(2, 2e-3))
    names = {float(note.get_text().removesuffix(" ms")): note.xy for note in ax.texts}
    assert {*names} == {10.0, 1.0, 0.1}
    assert [x / y for x, y in names.values()] == pytest.approx([5e-3 * ms for ms in names])


@pytest.mark.usefixtures("paper")
def test_names_of_durations_do_not_meet_and_a_hole_parts_the_shade():
    found = make_found(C=(25.0,)).assign_coords(f0=[60.0, 1000.0, 2e4])
    ax = drawn(draw_damage_boundary, found)
    names = [note.get_text() for note in ax.texts]
    assert names == ["16.7 ms", "1 ms", "0.1 ms", "0.05 ms"] and legend_words(ax)[-1] == "snaps"
    # At just 1.7 times 10 kHz its name is left out.
    f0 = [60.0, 100.0, 1000.0, 2000.0, 1e4, 1.7e4]
    found = found.isel(f0=[0, 0, 1, 1, 2, 2]).assign_coords(f0=f0)
    for holes, sizes in (([0], [5]), ([1], [4]), ([2], [2, 3]), ([2, 3], [2, 2]), ([1, 3, 4], [])):
        first = found.N_first.where(~found.f0.isin(np.take(f0, holes)))
        ax = drawn(draw_damage_boundary, found.assign(N_first=first))
        assert [len(shade.get_path().vertices) - 3 for shade in artists(ax, Polygon)] == sizes
    assert [note.get_text() for note in ax.texts] == ["16.7 ms", "1 ms", "0.0588 ms"]

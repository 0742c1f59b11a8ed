"""Islands that few runs or cheap levels might miss: against dense scans and eleven cosines."""

import numpy as np
import pytest
from small_studies import cases_of

import snapmap
from snapmap import Study
from snapmap.device.device import Beam, Device, batch
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.adaptive import UNCOMPARED, choose_survey
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Auto, Cosines
from snapmap.solver.settings import Run
from snapmap.thresholds.edges import Window, nothing_seen, outermost, scan
from snapmap.thresholds.effort import CLOSE_PLACES, CLOSE_STEP
from snapmap.thresholds.probe import Probe
from snapmap.thresholds.ragged import CLEAN_REACH, scan_ragged
from snapmap.thresholds.search import Search, close_edges
from snapmap.thresholds.survey import lowest, survey

CASES, MARKS = cases_of(__file__)["maps"], ([], [pytest.mark.long])
"""Of 22 modes the kernel takes most of a minute to compile."""


@pytest.mark.parametrize(
    ("beam", "device", "f0", "C", "how", "N"),
    [pytest.param(*case, marks=marks) for case, marks in zip(CASES, MARKS, strict=True)],
)
def test_maps_and_thresholds_have_the_islands_of_eleven_cosines(beam, device, f0, C, how, N):
    device, N = Device(Beam(**beam), **device), np.linspace(*N)
    rows = to_rows(0, f0, C, 0, [make_pulse(how["pulse"])])
    settings = Run(horizon=how["horizon"], start=how["start"])
    eleven = build_model(batch([device]), Cosines(modes=11))

    def snaps(step, N):
        return Probe(eleven.with_step(step), rows, settings).snaps(N[np.newaxis])[0]

    labels, finer_labels = (snaps(step, N) for step in (1.0, 0.5))
    sure = labels == finer_labels
    assert np.count_nonzero(np.diff(labels)) >= 3 and sure.mean() > 0.6
    cube = snapmap.sweep(Study(device, until="snap", **how), N, [f0], [C]).squeeze()
    np.testing.assert_array_equal(cube.t_snap.notnull()[sure], labels[sure])
    assert ((cube.agreed == UNCOMPARED) == (cube.level == 0)).all()

    edges = snapmap.threshold(Study(device, **how), [f0], [C]).squeeze()
    N = np.geomspace(0.97, 1.02, 60) * edges.N_first.item()
    snapped = snaps(0.5, N)
    first = N[np.argmax(snapped)]
    assert edges.ragged and not snapped[0] and snapped.any()
    assert abs(edges.N_first - first) <= edges.N_error < 0.02 * first


class Counted:
    """A model that counts the cells that it follows."""

    def __init__(self, model):
        self.model, self.device, self.count = model, model.device, 0

    def follow(self, cells, settings):
        self.count += cells.f0.size
        return self.model.follow(cells, settings)


def test_few_runs_beside_a_threshold_miss_no_stretch_that_counts(handout):
    """Of fast pulses, under which labels of some rows change back and forth."""
    models, settings = choose_survey(batch([handout]), Auto()), Run()
    f0 = np.array([[3e3], [5e3], [8e3], [11078.0], [15e3], [19734.0], [25e3]])
    rows, counted = to_rows(0, f0, [25.0, 100.0, 200.0]), Counted(models.decides)
    N = lowest(Search(models, rows, settings))
    edges, begins, *_ = close_edges(Probe(counted, rows, settings), N / 1.0001, N)
    window = Window(N / CLEAN_REACH, N * CLEAN_REACH, np.full(N.size, CLOSE_STEP))
    dense, dense_begins, _ = scan(Probe(models.decides, rows, settings), window.N)
    np.testing.assert_array_equal(begins, dense_begins)
    seen, there = ([each.high[each.row == i] for i in range(N.size)] for each in (edges, dense))
    for N_row, few, many in zip(N, seen, there, strict=True):
        narrow = np.diff(np.sort(many)) < 2 * CLOSE_STEP * N_row
        assert few.size > 1 or many.size == 1 or narrow.any()
    assert 0 < sum(many.size > 1 for many in there) < N.size / 2
    assert counted.count < N.size * 2 * CLOSE_PLACES[-1] / 2


def test_a_ragged_window_goes_on_below_every_change_of_any_model():
    """An island at 0.975 lies below the window, and a second one below that below the bound."""

    def model(*ends):
        return lambda N: np.where(np.searchsorted(ends, N, "right") % 2 == 1, 1.0, np.nan)

    window, nothing = Window(*np.array([[1.0], [1.2], [0.001]])), nothing_seen(1)
    ask = model(0.94, 0.945, 0.97, 0.98, 1.1, 2.0)
    others = [model(1.02, 2.0), model(0.972, 0.98, 1.1, 2.0)]
    for bound, first in ((0.9, 0.94), (0.96, 0.97)):
        seen, firsts = scan_ragged(ask, others, window, np.array([bound]), nothing)
        found = seen.edges.high[seen.edges.rising].min()
        assert found == pytest.approx(first, rel=1.1e-3) and seen.ends.all()
        assert firsts[:, 0] == pytest.approx([1.02, 0.972], rel=2.1e-3)


def test_the_bar_of_a_ragged_row_reaches_the_first_snap_of_the_finest_model(handout):
    """Here of one in four times the step, so that it differs."""
    device = batch([handout])
    models = choose_survey(device, Cosines(modes=3))
    other = models.decides.with_step(4.0)
    models = models._replace(others=(models.decides,), finest=other)
    rows, settings = to_rows(0, [1e4, 28e3], 0.025), Run(horizon=300.0)
    found = survey(Search(models, rows, settings))
    assert found.ragged.all()
    window = Window(found.N_first / 1.03, 1.03 * found.N_first, np.full(rows.f0.size, 1e-3))
    edges, *_ = scan(Probe(other, rows, settings, "snap"), window.N)
    firsts = outermost(edges.row, edges.high, rows.f0.size)[0]
    assert (abs(firsts - found.N_first) <= found.N_error).all()

"""What stands beside a threshold, seen by few runs, against a scan of it all."""

import numpy as np

from snapmap.device.device import batch
from snapmap.solver.adaptive import choose_survey
from snapmap.solver.cells import to_rows
from snapmap.solver.settings import Settings
from snapmap.thresholds.search import Window, asker, scan
from snapmap.thresholds.survey import CLEAN_REACH, CLOSE_PLACES, CLOSE_STEP, close_edges, lowest


def test_no_stretch_that_counts_is_missed_beside_a_threshold(handout):
    """Of fast pulses, under which labels of some rows change back and forth."""
    models, settings = choose_survey(batch([handout]), {"name": "auto"}), Settings()
    f0 = np.array([[3e3], [5e3], [8e3], [11078.0], [15e3], [19734.0], [25e3]])
    rows, asked = to_rows(0, f0, [25.0, 100.0, 200.0]), []
    N = lowest(models, rows, settings, 1e-4)
    counted = Counted(models.decides, asked)
    edges, begins, *_ = close_edges(counted, rows, settings, N / 1.0001, N)
    window = Window(N / CLEAN_REACH, N * CLEAN_REACH, np.full(N.size, CLOSE_STEP))
    dense, dense_begins, _ = scan(asker(models.decides, rows, settings), window.N)
    ragged = 0
    for row in range(N.size):
        seen, there = (np.sort(one.high[one.row == row]) for one in (edges, dense))
        ragged += there.size > 1
        widths = np.diff(there) / N[row]
        assert begins[row] == dense_begins[row]
        assert seen.size > 1 or there.size == 1 or widths.min() < 2 * CLOSE_STEP
    assert 0 < ragged < N.size / 2
    assert sum(asked) < N.size * 2 * CLOSE_PLACES[-1] / 2


class Counted:
    """A model that counts the cells that it follows."""

    def __init__(self, model, asked):
        self.model, self.device, self.asked = model, model.device, asked

    def follow(self, cells, settings):
        self.asked.append(cells.f0.size)
        return self.model.follow(cells, settings)

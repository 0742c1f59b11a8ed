"""Thresholds of slow pulses in the limit of short steps and many modes."""

import numpy as np

import snapmap


def test_close_thresholds_of_slow_pulses_are_those_of_many_modes_in_short_steps(handout, fix_step):
    """The error of M cosines falls as M^-4; it is taken from 9 and 11 in far shorter steps."""
    asked = {"f0": [100.0, 250.0], "C": [25.0], "horizon": 300.0}
    usual, close = (snapmap.threshold(handout, **asked, tolerance=to) for to in (1e-4, 1e-5))
    fix_step(1.0)
    nine, eleven = (
        snapmap.threshold(handout, **asked, tolerance=1e-6, model="cosines", modes=modes).N_first
        for modes in (9, 11)
    )
    exact = eleven + (eleven - nine) * 9**4 / (11**4 - 9**4)
    error = abs(close.N_first - exact)
    assert (error <= close.N_error).all() and (error <= 1e-5 * exact).all()
    assert (close.N_error < usual.N_error / 5).all()
    np.testing.assert_array_equal(close.N_always, close.N_first)


def test_ragged_and_fast_rows_are_never_extrapolated(handout):
    rows = {"f0": [3000.0, 11078.0], "C": [100.0], "horizon": 1500.0}
    usual, close = (snapmap.threshold(handout, **rows, tolerance=to) for to in (1e-4, 2.9e-5))
    assert (abs(close.N_first / usual.N_first - 1) < 2e-4).all()
    assert (close.N_error > usual.N_error / 2).all()

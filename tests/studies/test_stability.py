"""The hard cases: what a verdict means, and that by default nothing goes wrong unseen."""

import numpy as np

from snapmap.solver.outcome import FAILED, LATCHED, NEVER, RETURNED, SNAPPED, UNSNAPPED
from studies.stability import verdicts as V
from studies.stability.cases import CASES, MODELS, Case
from studies.stability.measure import measure

NAN = np.nan
SHORT = (
    *("handout's case", "five times as strong", "contact 4e5 N/m", "hard contact"),
    *("1 % below the threshold", "at the threshold", "1 % above the threshold", "f0 = 100 kHz"),
    *("N = 0", "N = 1e-6", "N = -1000", "N = 1e6", "Q 0.01 % above its limit"),
)


def runs(*each):
    """Runs of (outcome, t_snap, t_settled), whose ledgers close unless they failed."""
    return V.Runs(*np.array(each, float).T, np.zeros(len(each)))


def verdict(one, *fine):
    return int(V.judge(runs(one), runs(*fine) if fine else V.NO_RUNS)[0])


NEVER_RUN = (NEVER, NAN, 700.0)
SNAP_RUN = (SNAPPED, 400.0, NAN)
LATCHED_RUN = (LATCHED, 400.0, 2000.0)
OPEN, RETURNED_RUN = (UNSNAPPED, NAN, NAN), (RETURNED, 400.0, 2000.0)
FAILED_RUN = (FAILED, 400.0, NAN)
LATER, LATE = (LATCHED, 400.0, 3000.0), (SNAPPED, 440.0, NAN)
CHAOTIC = LATCHED_RUN, RETURNED_RUN
JUDGED = {
    V.SOUND: [
        *((run, run, run) for run in (NEVER_RUN, SNAP_RUN, LATCHED_RUN, OPEN)),
        # An open label contradicts no proof.
        *((OPEN, NEVER_RUN), (SNAP_RUN, LATCHED_RUN), (LATCHED_RUN, SNAP_RUN)),
        ((SNAPPED, 407.0, NAN), SNAP_RUN),
    ],
    V.UNSEEN: [
        *((SNAP_RUN, NEVER_RUN), (NEVER_RUN, SNAP_RUN)),
        *((OPEN, LATCHED_RUN), (RETURNED_RUN, LATCHED_RUN)),
        # A chaotic well does not excuse a missing snap.
        (NEVER_RUN, LATCHED_RUN, RETURNED_RUN),
    ],
    V.CAUGHT: [(FAILED_RUN, SNAP_RUN), (FAILED_RUN, NEVER_RUN), (FAILED_RUN,)],
    V.SHIFTED: [((SNAPPED, 409.0, NAN), SNAP_RUN)],
    # Where fine runs differ no run is wrong.
    V.SENSITIVE: [
        *((one, LATCHED_RUN, fine) for one in CHAOTIC for fine in (RETURNED_RUN, LATER)),
        *((one, SNAP_RUN, fine) for one in CHAOTIC for fine in (LATE, NEVER_RUN)),
    ],
    V.UNCHECKED: [(SNAP_RUN,), (SNAP_RUN, (FAILED, NAN, NAN))],
}


def test_verdicts_compare_a_run_with_the_fine_ones():
    for expected, cases in JUDGED.items():
        for one, *fine in cases:
            assert verdict(one, *fine) == expected, (one, fine)


def test_nothing_goes_wrong_unseen(handout):
    """Nor fails at the default step: the halved ones are enough for every one of these cells.

    With a cheap model of the kernel and the plain loop, at a few steps.
    """
    cases = [case for case in CASES if case.name in SHORT]
    models = {"3 cosines": MODELS["3 cosines"], "reference": {"name": "reference", "elements": 2}}
    cheap = measure(handout, cases, models, steps=(0.4, 1.0, 1.5), threads=2)
    assert cheap.sizes["case"] == len(SHORT)
    assert (cheap.verdict.drop_sel(case="hard contact") != V.UNSEEN).all()
    beyond = cheap.sel(model="reference", step=1.5).drop_sel(case=["N = 0", "hard contact"])
    assert (beyond.verdict == V.CAUGHT).all()
    assert not cheap.energy_error.sel(case="N = 0").any()
    soft = cheap.drop_sel(case="hard contact")  # refused by the reference
    assert (soft.default_verdict < V.CAUGHT).all()
    assert (soft.default_energy_error <= 1e-3).all() and (soft.halvings >= 0).all()
    refused = cheap.sel(case="hard contact", model="reference")
    assert (refused.verdict == V.REFUSED).all() and refused.default_verdict == V.REFUSED


def test_what_takes_too_long_is_left_out(handout):
    long = [Case("a minute", 1500.0, C=0.0, horizon=6e7)]
    found = measure(handout, long, {"5 cosines": MODELS["5 cosines"]}, steps=(0.8,))
    assert (found.default_verdict == V.LEFT_OUT).all() and (found.verdict == V.LEFT_OUT).all()
    assert (found.halvings == -1).all() and (found.limit > 0).all()
